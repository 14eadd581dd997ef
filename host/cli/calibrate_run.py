"""What `navtwin calibrate` does: check what was asked, calibrate, tell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from rich.text import Text

from host.calibrate.job import calibrate, procedures_of
from host.calibrate.page import page, sections, to_dict
from host.cli.exit_codes import EXIT_MET, EXIT_NOT_MET
from host.cli.output_files import check_files, for_people, write_json
from host.cli.terminal import print_section, progress_bar, standard_error
from host.record.atomic import write_whole
from host.record.result import RunRequest


@dataclass(frozen=True, slots=True)
class Outputs:
    """Where it goes."""

    store: Path | None
    page: Path | None
    json: str | None
    quiet: bool


def execute(request: RunRequest, asked: Sequence[str], outputs: Outputs) -> int:
    """Returns the exit code. Raises UserError."""
    names = procedures_of(asked)
    check_files(("--store", outputs.store), ("-o", outputs.page), ("--json", outputs.json))
    with progress_bar(f"calibrate {request.board}", outputs.quiet) as progress:
        outcome = calibrate(replace(request, notice=standard_error().print), names, progress)
    console = for_people(outputs.json)
    if not outputs.quiet:
        for section in sections(outcome):
            print_section(console, section)
    verdict = Text("all met", "bold green") if outcome.met else Text("not all met", "bold red")
    console.print(Text.assemble(f"calibration of {request.board}, seed {request.seed}: ", verdict))
    if outputs.store is not None:
        write_whole(outputs.store, outcome.content, "--store")
        console.print(f"written: {outputs.store}", soft_wrap=True)
    if outputs.page is not None:
        write_whole(outputs.page, page(outcome), "-o")
        console.print(f"written: {outputs.page}", soft_wrap=True)
    write_json(to_dict(outcome), outputs.json)
    return EXIT_MET if outcome.met else EXIT_NOT_MET
