"""`navtwin evaluate`: how far grades of sensors drift without a receiver."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from host.cli.exit_codes import guarded, whole_number
from host.cli.simulate_command import NOTHING_KEPT

DRIVES = 5


def evaluate_command(
    scenario: Annotated[
        str, typer.Argument(metavar="SCENARIO", help="The drive: a file, or the name of a board's.")
    ] = "long-legs",
    presets: Annotated[
        list[str] | None,
        typer.Option(
            "--preset", "-p", metavar="NAME", help="Sensor; may be repeated. Default: the published three."
        ),
    ] = None,
    drives: Annotated[
        int,
        typer.Option(
            "--drives",
            parser=whole_number,
            metavar="N",
            help="With seeds from --seed on; the RMS is over all.",
        ),
    ] = DRIVES,
    outages: Annotated[
        int, typer.Option("--outages", parser=whole_number, metavar="N", help="On each drive.")
    ] = 20,
    length: Annotated[
        int, typer.Option("--length", parser=whole_number, metavar="S", help="Of each outage.")
    ] = 60,
    gap: Annotated[
        int, typer.Option("--gap", parser=whole_number, metavar="S", help="Between two outages.")
    ] = 540,
    seed: Annotated[int, typer.Option("--seed", parser=whole_number, metavar="N")] = 1,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="FILE", help="A page with the drift (HTML).")
    ] = None,
    json: Annotated[
        str | None, typer.Option("--json", metavar="FILE|-", help="Figures as JSON; - is standard output.")
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress, no table.")] = False,
) -> None:
    """Cut the receiver off again and again, and see how far a reference filter drifts with each sensor.

    Beside the figures that were published for pos830, stim300 and adis16488. Ends with 1 when one of them
    is missed.
    """

    def command() -> int:
        from host.cli.evaluate_run import Asked, execute

        asked = Asked(scenario, tuple(presets or ()), drives, outages, length, gap, seed)
        return execute(asked, output, json, quiet)

    guarded(command, NOTHING_KEPT)
