"""What `navtwin table rates` and `federated` do: check what was asked, measure, tell."""

from __future__ import annotations

from pathlib import Path

from host.campaign.plan import parse_seeds
from host.cli.exit_codes import EXIT_MET, EXIT_NOT_MET
from host.cli.output_files import check_files, for_people, write_json
from host.cli.terminal import print_section
from host.record.atomic import write_whole
from host.record.errors import UserError
from host.tables import federated_page, rate_page
from host.tables.board_failures import board_failure_rows
from host.tables.federated_rows import failure_rows, filter_rows
from host.tables.rate_methods import rate_rows
from host.tables.sensor_failure import failure_section

RATES_FORMAT = "navtwin-rate-table-1"
FEDERATED_FORMAT = "navtwin-federated-table-1"
SHORTEST_DRIVE, LONGEST_DRIVE = 130, 3600
FAILURE_DRIVE_S = 360


def show_rates(
    arm: float, duration: float, seeds: str, output: Path | None, json_file: str | None, quiet: bool
) -> int:
    """Returns the exit code. Raises UserError."""
    if not 0.01 <= arm <= 10.0:
        raise UserError(f"--arm {arm:g}: must lie in 0.01 … 10 m, for example --arm 0.25")
    if not 2.0 <= duration <= 3600.0:
        raise UserError(f"--duration {duration:g}: must lie in 2 … 3600 s, for example --duration 60")
    chosen = tuple(parse_seeds(seeds))
    check_files(("-o", output), ("--json", json_file))
    rows = list(rate_rows(arm, duration, chosen))
    shown = rate_page.section(rows, arm, duration, len(chosen))
    console = for_people(json_file)
    if not quiet:
        print_section(console, shown)
    if output is not None:
        write_whole(output, rate_page.page(shown), "-o")
        console.print(f"written: {output}", soft_wrap=True)
    met = all(row.met for row in rows)
    about = {"format": RATES_FORMAT, "arm_m": arm, "duration_s": duration, "seeds": list(chosen), "met": met}
    write_json(about | {"rows": [rate_page.to_dict(row) for row in rows]}, json_file)
    return EXIT_MET if met else EXIT_NOT_MET


def show_federated(
    duration: int,
    seeds: str,
    failures: bool,
    board: bool,
    output: Path | None,
    json_file: str | None,
    quiet: bool,
) -> int:
    """Returns the exit code. Raises UserError."""
    if not SHORTEST_DRIVE <= duration <= LONGEST_DRIVE:
        raise UserError(
            f"--duration {duration}: must lie in {SHORTEST_DRIVE} … {LONGEST_DRIVE} s, for example"
            " --duration 300"
        )
    chosen = tuple(parse_seeds(seeds))
    check_files(("-o", output), ("--json", json_file))
    filters = list(filter_rows(duration, chosen))
    failed = list(failure_rows(FAILURE_DRIVE_S, chosen[0])) if failures else []
    sections = [federated_page.filter_section(filters, duration, len(chosen))]
    if failed:
        sections.append(
            failure_section(
                "One sub-filter's sensor fails",
                "Federated, fusion-feedback: the global solution from the beginning of the failure on.",
                failed,
            )
        )
    on_board = list(board_failure_rows(chosen[0])) if board else []
    if on_board:
        sections.append(
            failure_section(
                "One sub-filter's sensor fails, on the board",
                "The board on scenario chapter5, fusion-feedback: its words and its solution.",
                on_board,
            )
        )
    console = for_people(json_file)
    if not quiet:
        for one in sections:
            print_section(console, one)
    if output is not None:
        write_whole(output, federated_page.page(sections, filters), "-o")
        console.print(f"written: {output}", soft_wrap=True)
    met = all(row.met is not False for row in filters)
    met = met and all(row.met for row in failed) and all(row.met for row in on_board)
    about = {"format": FEDERATED_FORMAT, "duration_s": duration, "seeds": list(chosen), "met": met}
    rows = {
        "filters": [federated_page.filter_dict(row) for row in filters],
        "failures": [row.to_dict() for row in failed],
        "board_failures": [row.to_dict() for row in on_board],
    }
    write_json(about | rows, json_file)
    return EXIT_MET if met else EXIT_NOT_MET
