"""What `navtwin table antennas` does."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

from host.cli.exit_codes import EXIT_MET, EXIT_NOT_MET
from host.cli.output_files import check_files, for_people, write_json
from host.cli.table_run import check_seed
from host.cli.terminal import print_section
from host.record.atomic import write_whole
from host.tables.second_antenna import heading_rows
from host.tables.second_antenna_page import compass_section, heading_section, page, to_dict

FORMAT = "navtwin-second-antenna-table-1"


def show_antennas(seed: int, output: Path | None, json_file: str | None, quiet: bool) -> int:
    """Returns the exit code. Raises UserError."""
    check_seed(seed)
    check_files(("-o", output), ("--json", json_file))
    found = list(heading_rows(seed))
    rows = [row for row, _ in found]
    compass = max((told for _, told in found), key=len)
    console = for_people(json_file)
    if not quiet:
        print_section(console, heading_section(rows))
        print_section(console, compass_section(compass))
    if output is not None:
        write_whole(output, page(rows, compass), "-o")
        console.print(f"written: {output}", soft_wrap=True)
    met = all(row.met is not False for row in rows)
    told = {"rows": [to_dict(row) for row in rows], "gyro_compass": [asdict(row) for row in compass]}
    write_json({"format": FORMAT, "seed": seed, "met": met, **told}, json_file)
    return EXIT_MET if met else EXIT_NOT_MET
