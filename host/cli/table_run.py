"""What `navtwin table angles` and `coning` do: check what was asked, measure, tell."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path

from boards.hints import did_you_mean
from firmware.nav.attitude.profiles import PROFILES
from host.campaign.plan import parse_seeds
from host.cli.exit_codes import EXIT_MET, EXIT_NOT_MET
from host.cli.output_files import check_files, for_people, write_json
from host.cli.terminal import print_section
from host.record.atomic import write_whole
from host.record.errors import UserError
from host.sim.seeding import LARGEST_SEED
from host.tables.angle_page import page as angle_page
from host.tables.angle_page import sections as angle_sections
from host.tables.angle_page import summary, to_dict
from host.tables.angle_rows import CHIP, FEEDS, AngleRow
from host.tables.chip_angles import chip_row
from host.tables.coning import METHODS, Coning, coning_drifts
from host.tables.coning_page import page as coning_page
from host.tables.coning_page import section as coning_section
from host.tables.coning_page import to_dict as coning_dict
from host.tables.document import AXES, DocumentRow, document_rows
from host.tables.ideal_angles import ideal_row
from host.tables.turn_and_stop import stop_drift
from host.tables.turn_and_stop_page import page as drift_page
from host.tables.turn_and_stop_page import section as drift_section
from host.tables.turn_and_stop_page import to_dict as drift_dict

ANGLES_FORMAT = "navtwin-angle-tables-1"
DRIFT_FORMAT = "navtwin-drift-table-1"
COMPENSATIONS = ("off", "on")
CONING_FORMAT = "navtwin-coning-table-1"
CONING_LIMITS = (
    ("half-angle", 0.001, 30.0, "°"),
    ("frequency", 0.1, 100.0, "Hz"),
    ("duration", 1.0, 3600.0, "s"),
)


@dataclass(frozen=True, slots=True)
class AskedAngles:
    """The words of the command line."""

    axes: str
    angles: str | None
    feed: str
    arithmetic: str
    compensation: str
    seed: int


@dataclass(frozen=True, slots=True)
class AskedDrift:
    """The words of the command line."""

    arithmetic: str
    compensation: str
    seeds: str


def show_angles(asked: AskedAngles, output: Path | None, json_file: str | None, quiet: bool) -> int:
    """Returns the exit code. Raises UserError."""
    wanted = _wanted_rows(asked)
    feeds = chosen("--feed", asked.feed, FEEDS)
    arithmetics = chosen("--arithmetic", asked.arithmetic, PROFILES)
    compensations = chosen("--compensation", asked.compensation, COMPENSATIONS)
    if len(compensations) != 1:
        raise UserError(f"--compensation {asked.compensation}: one of both; for example --compensation off")
    check_seed(asked.seed)
    check_files(("-o", output), ("--json", json_file))
    rows = list(_measured(wanted, feeds, arithmetics, asked.seed, compensations == ("on",)))
    console = for_people(json_file)
    if not quiet:
        for section in (*angle_sections(rows), summary(rows)):
            print_section(console, section)
    if output is not None:
        write_whole(output, angle_page("Angles of the rotary table", rows), "-o")
        console.print(f"written: {output}", soft_wrap=True)
    about = {
        "format": ANGLES_FORMAT,
        "seed": asked.seed,
        "compensation": asked.compensation,
        "met": all(row.met for row in rows),
    }
    write_json(about | {"rows": [to_dict(row) for row in rows]}, json_file)
    return EXIT_MET if about["met"] else EXIT_NOT_MET


def _measured(
    wanted: Sequence[DocumentRow],
    feeds: Sequence[str],
    arithmetics: Sequence[str],
    seed: int,
    compensated: bool,
) -> Iterator[AngleRow]:
    for feed, row, name in product(feeds, wanted, arithmetics):
        yield chip_row(row, name, seed, compensated) if feed == CHIP else ideal_row(row, name)


def _wanted_rows(asked: AskedAngles) -> list[DocumentRow]:
    rows = [row for axis in chosen("--axis", asked.axes, AXES) for row in document_rows(axis)]
    if asked.angles is None:
        return rows
    wanted = []
    for text in asked.angles.split(","):
        found = [row for row in rows if row.angle_deg == _degrees(text)]
        if not found:
            raise UserError(
                f"--angle {text}: the tables of {asked.axes} have no such row; for example --angle 30,-90"
            )
        wanted += found
    return wanted


def _degrees(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise UserError(f"--angle {text}: not a number; for example --angle 30,-90") from None


def show_drift(asked: AskedDrift, output: Path | None, json_file: str | None, quiet: bool) -> int:
    """Returns the exit code. Raises UserError."""
    arithmetics = chosen("--arithmetic", asked.arithmetic, PROFILES)
    compensations = chosen("--compensation", asked.compensation, COMPENSATIONS)
    seeds = parse_seeds(asked.seeds)
    check_files(("-o", output), ("--json", json_file))
    drifts = [
        stop_drift(arithmetic, seeds, compensation == "on")
        for compensation, arithmetic in product(compensations, arithmetics)
    ]
    console = for_people(json_file)
    if not quiet:
        print_section(console, drift_section(drifts))
    if output is not None:
        write_whole(output, drift_page(drifts), "-o")
        console.print(f"written: {output}", soft_wrap=True)
    met = all(one.met is not False for one in drifts)
    write_json({"format": DRIFT_FORMAT, "met": met, "drifts": [drift_dict(one) for one in drifts]}, json_file)
    return EXIT_MET if met else EXIT_NOT_MET


def show_coning(
    size: tuple[float, float, float], arithmetic: str, output: Path | None, json_file: str | None, quiet: bool
) -> int:
    """`size`: half angle in °, frequency in Hz, duration in s. Returns the exit code. Raises UserError."""
    for value, (option, least, most, unit) in zip(size, CONING_LIMITS, strict=True):
        if not least <= value <= most:
            raise UserError(f"--{option} {value:g}: must lie in {least:g} … {most:g} {unit}")
    arithmetics = chosen("--arithmetic", arithmetic, PROFILES)
    check_files(("-o", output), ("--json", json_file))
    coning = Coning(math.radians(size[0]), size[1], size[2])
    drifts = list(coning_drifts(coning, METHODS, arithmetics))
    console = for_people(json_file)
    if not quiet:
        print_section(console, coning_section(coning, drifts))
    if output is not None:
        write_whole(output, coning_page(coning, drifts), "-o")
        console.print(f"written: {output}", soft_wrap=True)
    about = {"format": CONING_FORMAT, "coning": asdict(coning)}
    write_json(about | {"updates": [coning_dict(coning, one) for one in drifts]}, json_file)
    return EXIT_MET


def chosen(option: str, text: str, possible: Sequence[str]) -> tuple[str, ...]:
    """The names in a list with commas, each once. Raises UserError."""
    names = tuple(dict.fromkeys(name.strip() for name in text.split(",")))
    for name in names:
        if name not in possible:
            raise UserError(f"{option} {text}: {name!r} is not possible; {did_you_mean(name, possible)}")
    return names


def check_seed(seed: int) -> None:
    """Raises UserError for what is no seed."""
    if not 0 <= seed <= LARGEST_SEED:
        raise UserError(
            f"--seed {seed}: a seed is a whole number in 0 … {LARGEST_SEED}, for example --seed 1"
        )
