"""`navtwin serve`: the options."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from host.cli.exit_codes import guarded
from host.cli.run_options import (
    BoardName,
    ChangesAsInRun,
    Data,
    Figures,
    NoCapture,
    ProfileName,
    ScenarioName,
    Seed,
)

EPILOG = "\n".join(
    [
        "\b",
        "Examples:",
        "  navtwin serve car_mems -s static --uart gnss=pty:./gnss",
        "  navtwin serve car_mems --uart host=tcp://127.0.0.1:5760 --pace 0",
        "  navtwin serve car_mems --can udp_multicast:239.74.163.2 --control 127.0.0.1:5761",
        "",
        "Ctrl-C ends it; the folder --out is then complete.",
    ]
)


Uarts = Annotated[
    list[str] | None,
    typer.Option(
        "--uart",
        metavar="NAME=PLACE",
        help="pty, pty:./gnss, tcp://127.0.0.1:5760 or rfc2217://127.0.0.1:4000. May be repeated.",
    ),
]
Cans = Annotated[
    list[str] | None,
    typer.Option(
        "--can",
        metavar="[NAME=]INTERFACE:CHANNEL",
        help="An interface of python-can: socketcan:vcan0, slcan:/dev/ttyACM0, … May be repeated.",
    ),
]
Pace = Annotated[float, typer.Option("--pace", metavar="K", help="1: real time; 0: as fast as it goes.")]
Control = Annotated[
    str | None,
    typer.Option("--control", metavar="HOST:PORT", help="Commands as JSON lines, e.g. 127.0.0.1:5761."),
]
Paused = Annotated[bool, typer.Option("--paused", help="Wait for the command resume.")]
Duration = Annotated[
    str | None, typer.Option("--duration", metavar="S|endless", help="Default: the scenario's own.")
]
Out = Annotated[
    Path | None,
    typer.Option(
        "--out",
        metavar="DIR",
        help="Report, solution, capture. Default: runs/BOARD-SCENARIO-PROFILE-SEED-served.",
    ),
]
Stall = Annotated[
    float,
    typer.Option("--stall", metavar="S", help="Pace 0: so long the run waits for a client that stalls."),
]
Remote = Annotated[bool, typer.Option("--allow-remote", help="Listen where other machines can reach it.")]
Realtime = Annotated[
    bool, typer.Option("--realtime", help="Ask the system for real-time priority (Linux, as root).")
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Only places and the verdict.")]


def serve_command(
    board: BoardName,
    scenario: ScenarioName = None,
    uart: Uarts = None,
    can: Cans = None,
    pace: Pace = 1.0,
    control: Control = None,
    paused: Paused = False,
    duration: Duration = None,
    profile: ProfileName = None,
    seed: Seed = 1,
    changes: ChangesAsInRun = None,
    data: Data = None,
    out: Out = None,
    no_capture: NoCapture = False,
    stall: Stall = 10.0,
    allow_remote: Remote = False,
    realtime: Realtime = False,
    json: Figures = None,
    quiet: Quiet = False,
) -> None:
    """Run a board in real time and offer its UARTs and CAN buses to other programs.

    Clients may come and go as they like. With --control the board is paused, moved and broken meanwhile.
    """

    def command() -> int:
        from host.cli.serve_run import ServeOutputs, duration_changes, serve
        from host.record.result import RunRequest
        from host.serve.address import parse_address
        from host.serve.service import Wanted

        request = RunRequest(
            board=board,
            scenario=scenario,
            profile=profile,
            seed=seed,
            overrides=(*(changes or ()), *duration_changes(duration)),
            data_dir=data,
            out_dir=out,
            capture=not no_capture,
        )
        wanted = Wanted(
            uarts=tuple(uart or ()),
            cans=tuple(can or ()),
            pace=pace,
            control=None if control is None else parse_address(control, "--control", "127.0.0.1:5761"),
            paused=paused,
            allow_remote=allow_remote,
            stall_s=stall,
        )
        return serve(request, wanted, ServeOutputs(json, quiet, realtime))

    guarded(command)
