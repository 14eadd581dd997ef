"""`navtwin attitude`: attitude filters on recordings with a reference."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from host.cli.exit_codes import guarded
from host.cli.simulate_command import NOTHING_KEPT


def attitude_command(
    recordings: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="RECORDING…",
            help="BROAD trials (.npz, .mat, .hdf5), by path or by name below DATA/broad. Default: all there.",
        ),
    ] = None,
    feed: Annotated[
        str,
        typer.Option(
            "--feed", metavar="LIST", help="Of direct, bmi160, adis16407: past all chips, or through one."
        ),
    ] = "direct,bmi160,adis16407",
    beside: Annotated[
        str,
        typer.Option("--beside", metavar="LIST", help="Of vqf, imufusion; none for no other filter."),
    ] = "vqf,imufusion",
    arithmetic: Annotated[
        str,
        typer.Option("--arithmetic", metavar="LIST", help="Of float32, fixed, float64, for direct feed."),
    ] = "float32,fixed",
    gyro_delay_ms: Annotated[
        float,
        typer.Option(
            "--gyro-delay", metavar="MS", help="The gyros' own delay; our attitude is predicted ahead by it."
        ),
    ] = 0.0,
    data: Annotated[
        Path | None,
        typer.Option("--data", metavar="DIR", help="Real recordings. Default: NAVTWIN_DATA."),
    ] = None,
    json: Annotated[
        str | None,
        typer.Option("--json", metavar="FILE|-", help="All figures as JSON; - is standard output."),
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No table.")] = False,
) -> None:
    """Our drift compensation beside other filters: attitude errors as the BROAD data set defines them."""

    def command() -> int:
        from host.cli.attitude_run import Choice, execute

        choice = Choice(recordings or [], feed, beside, arithmetic, gyro_delay_ms)
        return execute(choice, data, json, quiet)

    guarded(command, NOTHING_KEPT)
