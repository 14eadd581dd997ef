"""`navtwin attach`: real hardware beside the twin."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from host.cli.exit_codes import guarded

app = typer.Typer(
    help="Real hardware: a board that is shadowed, a receiver in the emulated one's place.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

BoardName = Annotated[str, typer.Option("--board", "-b", metavar="NAME|DIR", help="Which board it is.")]
Profile = Annotated[
    str | None, typer.Option("--profile", "-p", metavar="NAME", help="Default: the board's own.")
]
Changes = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="As of navtwin run. May be repeated."),
]
Seconds = Annotated[
    float | None,
    typer.Option("--seconds", metavar="N", min=0.0, help="End after so long. Default: at Ctrl-C."),
]
Json = Annotated[
    str | None, typer.Option("--json", metavar="FILE|-", help="All figures as JSON; - is standard output.")
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No live view, no tables.")]


@app.callback()
def _group() -> None:
    """Real hardware: a board that is shadowed, a receiver in the emulated one's place."""


@app.command("chip")
def chip_command(
    chip: Annotated[str, typer.Argument(metavar="CHIP", help="bmi160 or adxl345.")],
    port: Annotated[
        str,
        typer.Option(
            "--port", metavar="URL|RECORD", help="Of the bridge: /dev/ttyUSB0 …; or what --record wrote."
        ),
    ],
    bus: Annotated[str, typer.Option("--bus", metavar="spi|i2c", help="How the chip is wired.")] = "spi",
    address: Annotated[
        str | None, typer.Option("--address", metavar="HEX", help="On I²C. Default: the chip's usual one.")
    ] = None,
    rate: Annotated[float, typer.Option("--rate", metavar="HZ", help="Samples a second.")] = 100.0,
    speed: Annotated[
        int | None,
        typer.Option("--speed", metavar="HZ", help="Of the bus. Default: 1000000 (SPI), 400000 (I²C)."),
    ] = None,
    no_power: Annotated[
        bool, typer.Option("--no-power", help="The chip has its own supply; the bridge must not feed it.")
    ] = False,
    seconds: Seconds = None,
    record: Annotated[
        Path | None,
        typer.Option("--record", metavar="FILE", help="All transactions, as tests of drivers replay them."),
    ] = None,
    json: Json = None,
    quiet: Quiet = False,
) -> None:
    """Show a sensor on the desk, behind a Bus Pirate, under the driver that is flashed.

    Ends with 0: the chip is there and set up, 1: it is not (what was read is told), 2: bad input or port.
    """

    def command() -> int:
        from host.attach.chip_bench import ChipRequest
        from host.cli.attach_chip_run import attach_chip, whole_address

        request = ChipRequest(
            chip=chip,
            port=port,
            bus=bus,
            address=whole_address(address),
            speed_hz=speed,
            rate_hz=rate,
            power=not no_power,
            record=record,
        )
        return attach_chip(request, seconds, json, quiet)

    guarded(command)


@app.command("board")
def board_command(
    port: Annotated[
        str,
        typer.Option(
            "--port",
            metavar="URL|CAPTURE",
            help="/dev/ttyUSB0, socket://HOST:PORT, rfc2217://HOST:PORT; or a capture, or a run's folder.",
        ),
    ],
    board: Annotated[
        str | None,
        typer.Option(
            "--board", "-b", metavar="NAME|DIR", help="Default: car_mems; of a capture, the recorded one."
        ),
    ] = None,
    profile: Profile = None,
    changes: Changes = None,
    baud: Annotated[
        int | None,
        typer.Option("--baud", metavar="N", help="Default: the board's own; if that is wrong, others."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Recording. Default: runs/BOARD-attached-DATE for a port."),
    ] = None,
    seconds: Seconds = None,
    json: Json = None,
    no_shadow: Annotated[
        bool, typer.Option("--no-shadow", help="Show and record only; compare nothing.")
    ] = False,
    feed: Annotated[
        str | None,
        typer.Option(
            "--feed",
            metavar="RUN|CAPTURE",
            help="Raw frames of this recording go to the board, which has no sensors of its own.",
        ),
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Show, record and shadow a real board that speaks our link.

    The twin runs the same firmware on the raw frames that the board sends (profile key raw_output) and
    compares every solution, bit for bit. Ends with 0: all equal, 1: a difference, 2: bad input or port, or
    nothing to compare.
    """

    def command() -> int:
        from host.cli.attach_run_board import BoardRequest, attach_board

        request = BoardRequest(
            port=port,
            board=board,
            profile=profile,
            overrides=tuple(changes or ()),
            baud=baud,
            out_dir=out,
            seconds=seconds,
            shadow=not no_shadow,
            feed=feed,
        )
        return attach_board(request, json, quiet)

    guarded(command)


@app.command("gnss")
def gnss_command(
    port: Annotated[
        str,
        typer.Option(
            "--port",
            metavar="URL",
            help="/dev/ttyUSB0, /dev/ttyACM0, rfc2217://HOST:PORT, socket://HOST:PORT.",
        ),
    ],
    board: BoardName = "car_mems",
    scenario: Annotated[
        str | None,
        typer.Option("--scenario", "-s", metavar="NAME|FILE", help="Default: static, where the receiver is."),
    ] = None,
    profile: Profile = None,
    changes: Changes = None,
    baud: Annotated[
        int | None,
        typer.Option("--baud", metavar="N", help="The receiver's rate now. Default: found by listening."),
    ] = None,
    wait: Annotated[
        float, typer.Option("--wait", metavar="N", min=0.0, help="Seconds to wait for the first fix.")
    ] = 120.0,
    record_only: Annotated[
        bool, typer.Option("--record-only", help="Judge nothing; allows a scenario that moves.")
    ] = False,
    seconds: Seconds = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", metavar="DIR", help="Report, solution, capture. Default: runs/BOARD-gnss-DATE."
        ),
    ] = None,
    json: Json = None,
    quiet: Quiet = False,
) -> None:
    """Run a board in real time with a real receiver in place of its emulated one.

    The firmware's driver configures the receiver, bit rate and all; the twin stands where the receiver's
    first fix is. Ends with 0: it ran on the receiver, 1: no position came in, 2: bad input or port.
    """

    def command() -> int:
        from host.cli.attach_run_gnss import GnssRequest, attach_gnss
        from host.record.result import RunRequest

        run = RunRequest(
            board=board, scenario=scenario, profile=profile, overrides=tuple(changes or ()), out_dir=out
        )
        return attach_gnss(GnssRequest(port, baud, wait, seconds, record_only, run), json, quiet)

    guarded(command)
