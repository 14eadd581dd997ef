"""`navtwin compare`: one stream of bus words through several arithmetics."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from host.cli.exit_codes import guarded, whole_number
from host.cli.simulate_command import NOTHING_KEPT


def compare_command(
    board: Annotated[
        str, typer.Argument(metavar="BOARD", help="A board with the attitude computer.")
    ] = "uav_ahrs",
    profiles: Annotated[
        str, typer.Option("--profiles", "-p", metavar="NAMES", help="Two or more arithmetics; with commas.")
    ] = "fixed,float32,float64",
    scenario: Annotated[
        str | None, typer.Option("--scenario", "-s", metavar="NAME|FILE", help="Default: the board's own.")
    ] = None,
    capture: Annotated[
        Path | None,
        typer.Option(
            "--capture", metavar="CAPTURE", help="The words of a capture, instead of a run made now."
        ),
    ] = None,
    seed: Annotated[int, typer.Option("--seed", parser=whole_number, metavar="N", help="Of all noise.")] = 1,
    changes: Annotated[
        list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="As for navtwin run.")
    ] = None,
    data: Annotated[
        Path | None, typer.Option("--data", metavar="DIR", help="Real recordings. Default: NAVTWIN_DATA.")
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", metavar="DIR", help="A folder for report.html and compare.json."),
    ] = None,
    cycles: Annotated[
        bool,
        typer.Option("--cycles/--no-cycles", help="Estimate the cycles of the kernels; takes some seconds."),
    ] = True,
    json: Annotated[
        str | None, typer.Option("--json", metavar="FILE|-", help="Figures as JSON; - is standard output.")
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress, no tables.")] = False,
) -> None:
    """Run fixed point, float32 and float64 in lockstep on one stream of bus words.

    First divergence, growth of the errors, saturations, cycles. float64 is the reference, or else the last
    one named. Ends with 1 when fixed is further than 0.01° RMS from float64.
    """

    def command() -> int:
        from host.cli.compare_run import AskedComparison, execute

        asked = AskedComparison(board, profiles, scenario, capture, seed, tuple(changes or ()), data, cycles)
        return execute(asked, out, json, quiet)

    guarded(command, NOTHING_KEPT)
