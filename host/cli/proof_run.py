"""What `navtwin proof` does: measure part by part, tell, judge."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator
from dataclasses import asdict
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

from boards.hints import did_you_mean
from host.cli.exit_codes import EXIT_MET, EXIT_NOT_MET
from host.cli.output_files import check_files
from host.cli.terminal import print_section, standard_error, standard_output
from host.record.atomic import write_whole
from host.record.errors import UserError
from host.report.numbers import NONE, number
from host.report.summary import MET, NOT_MET, Section
from host.sim.recording.locate import VARIABLE
from host.simulate.extras import must_have
from host.simulate.proof.figure import Figure

RESULT_FORMAT = "navtwin-proof-1"
PARTS = {
    "closure": ("scipy", "Closed loop over a trajectory's points at 200 Hz, 20 minutes"),
    "independent": ("pyins", "The closed loop's increments through python-ins, 20 minutes at 200 Hz"),
    "closed-forms": ("numpy", "Truth against answers on paper"),
    "joints": ("numpy", "Joints between segments, flanks of 0.5 s"),
    "noise": ("allantools", "Set noise, found again by allantools"),
    "bmi160": ("allantools", "Allan curves of a real BMI160 (NAVTWIN_DATA) beside its preset's, 0.1 to 50 s"),
    "drift": ("scipy", "A minute without a receiver, 20 times on each of 5 drives, loosely coupled filter"),
    "speed": ("numpy", "Generation: samples a second of one core's time, truth and all errors"),
}
"""The library that each needs, and its heading."""


def execute(parts: tuple[str, ...], json_file: str | None, quiet: bool) -> int:
    """Returns the exit code. Raises UserError."""
    for name in parts:
        if name not in PARTS:
            raise UserError(f"{name}: no such part; {did_you_mean(name, PARTS)}")
    check_files(("--json", json_file))
    console = standard_error() if json_file == "-" else standard_output()
    wanted = [name for name in PARTS if name in parts]
    for name in wanted:
        _must_have(name)
    if not parts:
        wanted, missing = _possible()
        for name, lacking in missing.items():
            console.print(f"{name}: left out, without {lacking}", soft_wrap=True)
    found: list[Figure] = []
    for name in wanted:
        figures = list(_figures(name))
        found += figures
        if not quiet:
            print_section(console, _section(PARTS[name][1], figures))
    missed = [figure for figure in found if figure.met is False]
    judged = sum(figure.met is not None for figure in found)
    console.print(f"{judged - len(missed)} of {judged} figures met", soft_wrap=True)
    if json_file is not None:
        rows = [asdict(figure) | {"met": figure.met} for figure in found]
        text = json.dumps({"format": RESULT_FORMAT, "figures": rows}, indent=1) + "\n"
        if json_file == "-":
            print(text, end="")
        else:
            write_whole(Path(json_file), text, "--json")
    return EXIT_NOT_MET if missed else EXIT_MET


def _possible() -> tuple[list[str], dict[str, str]]:
    """Parts whose libraries and recordings are there, and the others with what they lack."""
    missing = {name: library for name, (library, _) in PARTS.items() if find_spec(library) is None}
    if not os.environ.get(VARIABLE):
        missing["bmi160"] = VARIABLE
    return [name for name in PARTS if name not in missing], missing


def _must_have(part: str) -> None:
    library = PARTS[part][0]
    if library == "pyins":
        must_have(library, f"navtwin proof {part}", "pip install python-ins")
    else:
        must_have(library, f"navtwin proof {part}")


def _figures(part: str) -> Iterator[Figure]:
    module = import_module(f"host.simulate.proof.{part.replace('-', '_')}")
    figures: Callable[[], Iterator[Figure]] = module.figures
    return figures()


def _section(title: str, figures: list[Figure]) -> Section:
    columns = ("figure", "ours", "unit", "document", "must be", "verdict")
    return Section(title, columns, tuple(map(_row, figures)))


def _row(figure: Figure) -> tuple[str, ...]:
    met = figure.met
    words = NONE if met is None else MET if met else NOT_MET
    return figure.what, number(figure.ours), figure.unit, figure.document or NONE, _limit(figure), words


def _limit(figure: Figure) -> str:
    if figure.least is not None and figure.most is not None:
        return f"{figure.least:.3g} … {figure.most:.3g}"
    if figure.least is not None:
        return f"≥ {figure.least:.3g}"
    return NONE if figure.most is None else f"≤ {figure.most:.3g}"
