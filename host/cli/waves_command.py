"""`navtwin waves`: the levels of a board's lines, from a capture."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from host.cli.exit_codes import guarded


def waves_command(
    capture: Annotated[
        Path, typer.Argument(metavar="CAPTURE", help="run.mcap, run.mcap.part, or the folder of a run.")
    ],
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="FILE.vcd", help="For GTKWave, PulseView, sigrok-cli.")
    ],
    bus: Annotated[
        list[str] | None,
        typer.Option("--bus", "-b", metavar="NAME", help="As on the board: spi1. Repeatable; default: all."),
    ] = None,
    begin: Annotated[float, typer.Option("--from", metavar="S", help="Virtual time, s.")] = 0.0,
    end: Annotated[
        float | None, typer.Option("--to", metavar="S", help="Virtual time, s; not included. Default: all.")
    ] = None,
    rate: Annotated[
        list[str] | None,
        typer.Option(
            "--rate",
            metavar="NAME=HZ",
            help="Clock, baud or bit rate of a bus where the capture does not tell it (gnss=9600).",
        ),
    ] = None,
    json: Annotated[
        str | None, typer.Option("--json", metavar="FILE|-", help="What was drawn, as JSON.")
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar.")] = False,
) -> None:
    """Draw the levels of SPI, I²C, UART and CAN lines with their timing, as a VCD file."""

    def command() -> int:
        from host.cli.waves_run import make_waves
        from host.waves.drawing import WavesRequest

        return make_waves(WavesRequest(capture, output, bus or [], rate or [], begin, end), json, quiet)

    guarded(command, interrupted="interrupted; no file was written")
