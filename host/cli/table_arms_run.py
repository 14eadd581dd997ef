"""What `navtwin table arms` does."""

from __future__ import annotations

import math
from pathlib import Path

from host.cli.exit_codes import EXIT_MET
from host.cli.output_files import check_files, for_people, write_json
from host.cli.table_run import check_seed
from host.cli.terminal import print_section
from host.record.atomic import write_whole
from host.record.errors import UserError
from host.tables.arm_page import page, section, to_dict
from host.tables.arm_rows import arm_rows

FORMAT = "navtwin-arm-table-1"
SHORTEST, LONGEST = 0.01, 10.0


def parse_arms(text: str) -> tuple[float, ...]:
    """Lengths in m. Raises UserError."""
    try:
        arms = tuple(float(one) for one in text.split(","))
    except ValueError:
        arms = ()
    if not arms or not all(math.isfinite(arm) and SHORTEST <= arm <= LONGEST for arm in arms):
        raise UserError(
            f"--arms {text}: lengths in m with commas, each {SHORTEST:g} … {LONGEST:g}, such as 0.25,1"
        )
    return arms


def show_arms(arms: str, seed: int, output: Path | None, json_file: str | None, quiet: bool) -> int:
    """Returns the exit code. Raises UserError."""
    check_seed(seed)
    lengths = parse_arms(arms)
    check_files(("-o", output), ("--json", json_file))
    rows = list(arm_rows(lengths, seed))
    shown = section(rows, seed)
    console = for_people(json_file)
    if not quiet:
        print_section(console, shown)
    if output is not None:
        write_whole(output, page(shown, rows), "-o")
        console.print(f"written: {output}", soft_wrap=True)
    write_json({"format": FORMAT, "seed": seed, "rows": [to_dict(row) for row in rows]}, json_file)
    return EXIT_MET
