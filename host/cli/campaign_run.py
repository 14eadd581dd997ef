"""What `navtwin campaign` and `navtwin sweep` do: plan, run, write, print, judge."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from host.baseline.comparison import Comparison, compared, must_fit
from host.baseline.file import Baseline, campaign_runs, parse_tolerance, read_baseline
from host.campaign.campaign import Executor, Finished, make_plan, run_campaign
from host.campaign.folder import REPORT, RESULT, SUMMARY
from host.campaign.identity import campaign_manifest
from host.campaign.page import render
from host.campaign.plan import Plan, parse_changes, parse_seeds, parse_values
from host.campaign.series import course
from host.campaign.summary import Summary, summarised
from host.campaign.tables import sections, verdict
from host.campaign.work import Reduce
from host.cli.exit_codes import EXIT_MET, EXIT_NOT_MET
from host.cli.output_files import check_files, for_people, write_json
from host.cli.run_command import print_comparison
from host.cli.terminal import print_section, standard_error
from host.record.atomic import write_whole
from host.record.errors import UserError

MOST_WORKERS = 512


@dataclass(frozen=True, slots=True)
class Outputs:
    """Where results go, and what they are judged by."""

    out: Path | None
    json: str | None
    markdown: Path | None
    quiet: bool
    fresh: bool = False
    pass_share: str = "100%"
    baseline: Path | None = None
    tolerance: str = "5%"
    junit: Path | None = None


def ask(
    board: str,
    scenario: str | None,
    seeds: str,
    profiles: str | None,
    changes: Sequence[str] | None,
    data: Path | None,
) -> Plan:
    """The plan that the command line asks for. Raises UserError."""
    if data is not None and not data.is_dir():
        raise UserError(f"--data {data}: no such folder; for example --data ~/recordings")
    fixed, swept = parse_changes(changes or ())
    chosen = parse_values(profiles, f"--profile {profiles}") if profiles else ()
    return make_plan(board, scenario, chosen, parse_seeds(seeds), fixed, swept, data)


def execute(plan: Plan, outputs: Outputs, workers: int | None, scheduler: str | None) -> int:
    """`navtwin campaign`. Returns the exit code. Raises UserError."""
    _, ok = run_and_tell(plan, outputs, workers, scheduler, "campaign")
    return EXIT_MET if ok else EXIT_NOT_MET


def run_and_tell(
    plan: Plan, outputs: Outputs, workers: int | None, scheduler: str | None, kind: str
) -> tuple[Finished, bool]:
    """Run the campaign, or what is left of it; write, print and judge. Raises UserError."""
    share = parse_share(outputs.pass_share)
    tolerance = parse_tolerance(outputs.tolerance)
    baseline = None if outputs.baseline is None else read_baseline(outputs.baseline)
    check_files(("--json", outputs.json), ("--markdown", outputs.markdown), ("--junit", outputs.junit))
    folder = outputs.out or default_folder(plan, kind)
    if baseline is not None:
        must_fit(baseline, campaign_manifest(plan, kind))
    executor = make_executor(plan, workers, scheduler)
    with progress_bar(f"{Path(plan.board).name} {Path(plan.scenario).stem}", outputs.quiet) as progress:
        finished = run_campaign(
            plan,
            folder,
            executor,
            kind=kind,
            fresh=outputs.fresh,
            notice=standard_error().print,
            progress=progress,
        )
    summary = summarised(finished)
    comparison = None if baseline is None else _compared(baseline, finished, tolerance)
    ok = summary.ok(share) and (comparison is None or comparison.ok)
    _write(finished, summary, comparison, outputs, share, ok)
    _print(finished, summary, comparison, outputs)
    return finished, ok


def make_executor(
    plan: Plan, workers: int | None, scheduler: str | None, reduce: Reduce = course
) -> Executor:
    """Local processes, or a cluster. Raises UserError."""
    if scheduler is not None:
        from host.campaign.cluster import Cluster

        if workers is not None:
            raise UserError("--workers: the cluster of --scheduler has its own; leave one of the two out")
        return Cluster(scheduler, reduce)
    from host.campaign.pool import LocalPool

    count = workers if workers is not None else len(os.sched_getaffinity(0))
    if not 1 <= count <= MOST_WORKERS:
        raise UserError(f"--workers {count}: must lie in 1 … {MOST_WORKERS}; for example --workers 4")
    return LocalPool(count, reduce, plan.request(next(plan.setups()), plan.seeds[0]))


def default_folder(plan: Plan, kind: str) -> Path:
    """runs/KIND-BOARD-SCENARIO."""
    return Path("runs") / f"{kind}-{Path(plan.board).name}-{Path(plan.scenario).stem}"


def parse_share(text: str) -> float:
    """`95%` or `0.95`. Raises UserError."""
    try:
        share = float(text.removesuffix("%")) / (100 if text.endswith("%") else 1)
    except ValueError:
        share = -1.0
    if not 0 <= share <= 1:
        raise UserError(f"--pass-share {text}: must lie in 0 … 100 %; for example --pass-share 95%")
    return share


def _compared(baseline: Baseline, finished: Finished, tolerance: float) -> Comparison:
    return compared(baseline, campaign_runs(finished.rows, finished.manifest), finished.manifest, tolerance)


def _write(
    finished: Finished,
    summary: Summary,
    comparison: Comparison | None,
    outputs: Outputs,
    share: float,
    ok: bool,
) -> None:
    found: dict[str, Any] = summary.to_dict(finished.manifest, share)
    text = json.dumps(found, indent=1) + "\n"
    write_whole(finished.folder / SUMMARY, text, "--out")
    extra = [] if comparison is None else [comparison.section()]
    write_whole(finished.folder / REPORT, render(finished, summary, ok, extra), "--out")
    if outputs.json is not None:
        judged = {} if comparison is None else {"ok": ok, "baseline": comparison.to_dict()}
        write_json(found | judged, outputs.json)
    if outputs.junit is not None:
        from host.cli.campaign_junit import campaign_junit

        write_whole(outputs.junit, campaign_junit(finished, summary, share, comparison), "--junit")
    if outputs.markdown is not None:
        from host.report.markdown import summary as markdown

        title = f"{finished.manifest['board']} {finished.manifest['scenario']}"
        shown = [*extra, *sections(summary)]
        write_whole(outputs.markdown, markdown(title, verdict(summary), shown), "--markdown")


def _print(finished: Finished, summary: Summary, comparison: Comparison | None, outputs: Outputs) -> None:
    console = for_people(outputs.json)
    if not outputs.quiet:
        console.print()
        for section in sections(summary):
            print_section(console, section)
    resumed = f" ({finished.resumed:,} of them were there already)" if finished.resumed else ""
    console.print(f"{verdict(summary)}{resumed}", soft_wrap=True)
    if comparison is not None:
        print_comparison(console, comparison, outputs.quiet)
    console.print(f"result: {finished.folder / RESULT}  report: {finished.folder / REPORT}", soft_wrap=True)


@contextmanager
def progress_bar(title: str, quiet: bool) -> Iterator[Callable[[int, int], None] | None]:
    """A bar on standard error that tells the time left; nothing when quiet or not in a terminal."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    console = standard_error()
    if quiet or not console.is_terminal:
        yield None
        return
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TextColumn("runs,"))
    left = (TimeRemainingColumn(), TextColumn("left"))
    with Progress(*columns, *left, console=console, auto_refresh=False, transient=True) as bar:
        task = bar.add_task(title, total=None)

        def show(done: int, total: int) -> None:
            bar.update(task, completed=done, total=total)
            bar.refresh()

        yield show
