"""What `navtwin compare` does: get the words, run the lanes, tell."""

from __future__ import annotations

import json
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from firmware.nav.attitude.profiles import PROFILES
from host.cli.exit_codes import EXIT_MET, EXIT_NOT_MET
from host.cli.output_files import check_files, for_people, write_json
from host.cli.table_run import chosen
from host.cli.terminal import print_section, progress_bar
from host.compare.cost import PRICED, cost_of
from host.compare.cost_page import section as cost_section
from host.compare.cost_page import to_dict as cost_dict
from host.compare.lockstep import compare
from host.compare.page import page, sections, to_dict
from host.compare.source import Source, from_capture, from_run
from host.compare.word_stream import bursts_of
from host.record.atomic import made_aside
from host.record.errors import UserError
from host.record.result import Progress, RunRequest

RESULT_FORMAT = "navtwin-comparison-1"


@dataclass(frozen=True, slots=True)
class AskedComparison:
    """The words of the command line."""

    board: str
    profiles: str
    scenario: str | None
    capture: Path | None
    seed: int
    changes: tuple[str, ...]
    data: Path | None
    cycles: bool


def execute(asked: AskedComparison, out: Path | None, json_file: str | None, quiet: bool) -> int:
    """Returns the exit code. Raises UserError."""
    arithmetics = chosen("--profiles", asked.profiles, PROFILES)
    if len(arithmetics) < 2:
        raise UserError(
            f"--profiles {asked.profiles}: nothing to compare with; for example --profiles fixed,float64"
        )
    if asked.capture is not None and (asked.scenario is not None or asked.changes):
        raise UserError("--capture brings its own scenario and settings; leave out --scenario and --set")
    check_files(("--json", json_file))
    if out is not None and out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise UserError(f"--out {out}: exists already; name a new folder")
    with progress_bar("compare", quiet) as progress, _source(asked, arithmetics, progress) as source:
        comparison = compare(arithmetics, source.config, bursts_of(source.capture))
        priced = [name for name in arithmetics if name in PRICED and asked.cycles]
        costs = [cost_of(name, source.config, bursts_of(source.capture)) for name in priced]
        name = source.name
    title = f"{name}: {', '.join(arithmetics)} on one stream of bus words"
    found = {"format": RESULT_FORMAT, "source": name, **to_dict(comparison)}
    if costs:
        found["cycles"] = {one.arithmetic: cost_dict(one) for one in costs}
    tables = sections(comparison, [cost_section(costs)] if costs else [])
    console = for_people(json_file)
    if not quiet:
        for section in tables:
            print_section(console, section)
    if out is not None:
        _write(out, page(title, comparison, tables), found)
        console.print(f"written: {out / 'report.html'}", soft_wrap=True)
    write_json(found, json_file)
    return EXIT_NOT_MET if comparison.met is False else EXIT_MET


def _source(
    asked: AskedComparison, arithmetics: tuple[str, ...], progress: Progress | None
) -> AbstractContextManager[Source]:
    if asked.capture is not None:
        return nullcontext(from_capture(asked.capture))
    return from_run(
        RunRequest(
            board=asked.board,
            scenario=asked.scenario,
            profile=arithmetics[0],
            seed=asked.seed,
            overrides=asked.changes,
            data_dir=asked.data,
            progress=progress,
        )
    )


def _write(out: Path, report: str, found: dict[str, Any]) -> None:
    with made_aside(out, "--out") as folder:
        folder.mkdir()
        (folder / "report.html").write_text(report, encoding="utf-8")
        (folder / "compare.json").write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
