"""`navtwin calibrate`: a board's own calibration on a simulated table."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from host.cli.exit_codes import guarded
from host.cli.run_options import BoardName, ChangesAsInRun, Figures, ProfileName, Seed
from host.cli.simulate_command import NOTHING_KEPT


def calibrate_command(
    board: BoardName,
    procedures: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[PROCEDURE]...",
            help="accelerometers, rates, earth-rate, compass, ellipse, alignment, or all."
            " Default: accelerometers rates compass alignment.",
        ),
    ] = None,
    scenario: Annotated[
        str | None,
        typer.Option("--scenario", "-s", metavar="NAME|FILE", help="One of rest. Default: turntable."),
    ] = None,
    profile: ProfileName = None,
    seed: Seed = 1,
    changes: ChangesAsInRun = None,
    store: Annotated[
        Path | None,
        typer.Option("--store", metavar="FILE", help="Keep what the board's flash holds in the end."),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="FILE", help="A page with tables and curves.")
    ] = None,
    json: Figures = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress, no tables.")] = False,
) -> None:
    """Calibrate a board on a simulated table, by its own screen and keys, and judge what it has found.

    Power the same specimen up with it: navtwin run BOARD --set board.flash.calibration.file=FILE
    """

    def command() -> int:
        from host.cli.calibrate_run import Outputs, execute
        from host.record.result import RunRequest

        request = RunRequest(
            board=board, scenario=scenario, profile=profile, seed=seed, overrides=tuple(changes or ())
        )
        return execute(request, procedures or [], Outputs(store, output, json, quiet))

    guarded(command, NOTHING_KEPT)
