"""`navtwin faults`: every fault at every place of a board."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from host.cli.campaign_command import Board, Changes, Data, Fresh, Quiet, Scenario, Scheduler, Workers
from host.cli.exit_codes import CAMPAIGN_INTERRUPTED, guarded


def faults_command(
    board: Board,
    scenario: Scenario = None,
    seed: Annotated[int, typer.Option("--seed", metavar="N", help="Of all noise.")] = 1,
    profile: Annotated[
        str | None, typer.Option("--profile", "-p", metavar="NAME", help="Default: the board's own.")
    ] = None,
    at_s: Annotated[
        float | None, typer.Option("--at", metavar="S", help="When they strike. Default: a third of the run.")
    ] = None,
    duration_s: Annotated[
        float, typer.Option("--for", metavar="S", help="How long those last that last.")
    ] = 10.0,
    only: Annotated[
        str | None, typer.Option("--only", metavar="KIND,KIND", help="Default: every kind of fault.")
    ] = None,
    changes: Changes = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="Default: runs/faults-BOARD-SCENARIO.")
    ] = None,
    fresh: Fresh = False,
    data: Data = None,
    quiet: Quiet = False,
) -> None:
    """Strike a board with every fault there is: what fired, when it was told, its effect, the recovery.

    Writes faults.csv and faults.html (an FMEA sheet). Ends with 1 when a fault did not strike, or was not
    recovered from.
    """

    def command() -> int:
        from host.cli.faults_run import FaultRequest, execute_faults

        asked = FaultRequest(
            board, scenario, seed, profile, at_s, duration_s, only, tuple(changes or ()), data
        )
        return execute_faults(asked, out, workers, scheduler, fresh, quiet)

    guarded(command, CAMPAIGN_INTERRUPTED)
