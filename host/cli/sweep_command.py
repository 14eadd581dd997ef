"""`navtwin sweep`: how errors grow with one quantity."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from host.cli.campaign_command import (
    Board,
    Changes,
    Data,
    Fresh,
    Json,
    Markdown,
    Profiles,
    Quiet,
    Scenario,
    Scheduler,
    Seeds,
    Workers,
)
from host.cli.exit_codes import CAMPAIGN_INTERRUPTED, guarded


def sweep_command(
    board: Board,
    key: Annotated[
        str,
        typer.Option(
            "--key",
            "-k",
            metavar="KEY",
            help="bus-clock, interrupt-latency, sample-clock-error, gnss-latency, task-budget[:NAME],"
            " or a key of --set.",
        ),
    ],
    values: Annotated[
        str | None, typer.Option("--values", metavar="A,B,C", help="Default: some around the usual one.")
    ] = None,
    scenario: Scenario = None,
    seeds: Seeds = "1-5",
    profile: Profiles = None,
    changes: Changes = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="Default: runs/sweep-BOARD-SCENARIO-KEY.")
    ] = None,
    fresh: Fresh = False,
    json: Json = None,
    markdown: Markdown = None,
    data: Data = None,
    quiet: Quiet = False,
) -> None:
    """Sweep one quantity of the board or scenario: errors against it, as table, CSV and report.

    Writes what a campaign writes, and curves.csv. Ends with 1 when a run did not reach its end; expectations
    that are missed on the way are the answer, not a failure.
    """

    def command() -> int:
        from host.cli.campaign_run import Outputs
        from host.cli.sweep_run import execute_sweep

        outputs = Outputs(out, json, markdown, quiet, fresh, "0%")
        asked = (board, scenario, seeds, profile, changes, data)
        return execute_sweep(asked, key, values, outputs, workers, scheduler)

    guarded(command, CAMPAIGN_INTERRUPTED)
