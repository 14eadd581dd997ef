"""`navtwin campaign`: many runs, their spread, and a verdict."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from host.cli.exit_codes import CAMPAIGN_INTERRUPTED, guarded

Board = Annotated[str, typer.Argument(metavar="BOARD", help="A board's name, or a folder with a board.toml.")]
Scenario = Annotated[
    str | None, typer.Option("--scenario", "-s", metavar="NAME|FILE", help="Default: the board's own.")
]
Seeds = Annotated[
    str, typer.Option("--seeds", metavar="1-200", help="One run each; ranges and lists: 1-20,31.")
]
Profiles = Annotated[
    str | None,
    typer.Option("--profile", "-p", metavar="A,B", help="Default: the board's own."),
]
Changes = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=A,B,C",
        help="As for run; several values are swept, every combination is run. May be repeated.",
    ),
]
Data = Annotated[
    Path | None, typer.Option("--data", metavar="DIR", help="Real recordings. Default: NAVTWIN_DATA.")
]
Workers = Annotated[
    int | None, typer.Option("--workers", "-j", metavar="N", help="Processes. Default: one a core.")
]
Scheduler = Annotated[
    str | None,
    typer.Option("--scheduler", metavar="tcp://HOST:PORT", help="Run on an existing Dask cluster instead."),
]
Json = Annotated[
    str | None, typer.Option("--json", metavar="FILE|-", help="The summary as JSON; - is standard output.")
]
Markdown = Annotated[
    Path | None, typer.Option("--markdown", metavar="FILE", help="A summary for the page of a merge.")
]
Junit = Annotated[
    Path | None, typer.Option("--junit", metavar="FILE", help="Expectations over all runs as JUnit XML.")
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress, no tables.")]
Fresh = Annotated[bool, typer.Option("--fresh", help="Forget an earlier campaign in the folder --out.")]
Share = Annotated[
    str, typer.Option("--pass-share", metavar="95%", help="So many runs must meet all expectations.")
]
Baseline = Annotated[
    Path | None,
    typer.Option("--baseline", metavar="FILE", help="Ends with 1 when figures are worse than these."),
]
Tolerance = Annotated[
    str, typer.Option("--tolerance", metavar="5%", help="So much worse than the baseline is still good.")
]


def campaign_command(
    board: Board,
    scenario: Scenario = None,
    seeds: Seeds = "1-20",
    profile: Profiles = None,
    changes: Changes = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Default: runs/campaign-BOARD-SCENARIO."),
    ] = None,
    fresh: Fresh = False,
    json: Json = None,
    junit: Junit = None,
    markdown: Markdown = None,
    baseline: Baseline = None,
    tolerance: Tolerance = "5%",
    pass_share: Share = "100%",
    data: Data = None,
    quiet: Quiet = False,
) -> None:
    """Run a board over many seeds and swept values.

    Writes runs.parquet (one row a run), summary.json and report.html into the folder --out. The same command
    again goes on where a killed one ended. Ends with 1 when runs did not meet the scenario's expectations.
    """

    def command() -> int:
        from host.cli.campaign_run import Outputs, ask, execute

        asked = ask(board, scenario, seeds, profile, changes, data)
        outputs = Outputs(out, json, markdown, quiet, fresh, pass_share, baseline, tolerance, junit)
        return execute(asked, outputs, workers, scheduler)

    guarded(command, CAMPAIGN_INTERRUPTED)
