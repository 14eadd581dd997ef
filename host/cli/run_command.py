"""`navtwin run`: one run from the command line."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path

from rich.console import Console

from boards.description import load_board
from host.baseline.comparison import Comparison, compared
from host.baseline.file import Baseline, parse_tolerance, read_baseline, run_of_result
from host.cli.exit_codes import EXIT_MET, EXIT_NOT_MET
from host.cli.junit import junit_xml
from host.cli.output_files import check_files, for_people, write_json
from host.cli.terminal import (
    print_result,
    print_section,
    print_verdict,
    progress_bar,
    standard_error,
)
from host.record.atomic import write_whole
from host.record.command_line import command_line
from host.record.errors import UserError
from host.record.result import RunRequest, RunResult
from host.report.markdown import run_summary


@dataclass(frozen=True, slots=True)
class Outputs:
    """Where the figures go besides the run's folder."""

    json: str | None
    junit: Path | None
    markdown: Path | None
    quiet: bool
    baseline: Path | None = None
    tolerance: str = "5%"


def execute(request: RunRequest, outputs: Outputs) -> int:
    """Run, write and print. Returns the exit code. Raises UserError for what the user got wrong."""
    check_data(request.data_dir)
    check_files(("--json", outputs.json), ("--junit", outputs.junit), ("--markdown", outputs.markdown))
    tolerance = parse_tolerance(outputs.tolerance)
    baseline = None if outputs.baseline is None else read_baseline(outputs.baseline)
    request = with_folder(request)
    from host.run.runner import run

    with progress_bar(f"{request.board} {request.scenario or ''}".strip(), outputs.quiet) as progress:
        result = run(replace(request, progress=progress, notice=standard_error().print))
    comparison = None if baseline is None else _compared(baseline, result, tolerance)
    _write(result, outputs, command_line(request), comparison)
    console = for_people(outputs.json)
    if not outputs.quiet:
        print_result(console, result)
    print_verdict(console, result)
    if comparison is not None:
        print_comparison(console, comparison, outputs.quiet)
    met = result.ok and (comparison is None or comparison.ok)
    return EXIT_MET if met else EXIT_NOT_MET


def print_comparison(console: Console, comparison: Comparison, quiet: bool) -> None:
    """What has become worse or may have, also when `quiet`; else one line that nothing has."""
    bad = comparison.worse or comparison.unsure
    if comparison.section().rows and (bad or not quiet):
        print_section(console, comparison.section())
    else:
        console.print(comparison.verdict(), soft_wrap=True)


def _compared(baseline: Baseline, result: RunResult, tolerance: float) -> Comparison:
    assert result.out_dir is not None
    manifest = json.loads((result.out_dir / "manifest.json").read_text(encoding="utf-8"))
    return compared(baseline, [run_of_result(result)], manifest, tolerance)


def with_folder(request: RunRequest) -> RunRequest:
    """The request with its default folder: runs/BOARD-SCENARIO-PROFILE-SEED."""
    if request.out_dir is not None:
        return request
    board = load_board(request.board)
    scenario = Path(request.scenario).stem if request.scenario else board.default_scenario
    profile = request.profile or board.default_profile
    return replace(request, out_dir=Path("runs") / f"{board.name}-{scenario}-{profile}-{request.seed}")


def _write(result: RunResult, outputs: Outputs, command: str, comparison: Comparison | None) -> None:
    if outputs.json is not None:
        document = result.to_dict()
        if comparison is not None:
            document["baseline"] = comparison.to_dict()
        write_json(document, outputs.json)
    if outputs.junit is not None:
        write_whole(outputs.junit, junit_xml(result, command), "--junit")
    if outputs.markdown is not None:
        extra = [] if comparison is None else [comparison.section()]
        write_whole(outputs.markdown, run_summary(result, command, extra), "--markdown")


def check_data(folder: Path | None) -> None:
    """Of recordings. Raises UserError for one that is not there."""
    if folder is not None and not folder.is_dir():
        raise UserError(f"--data {folder}: no such folder; for example --data ~/recordings")
