"""What `navtwin table cycles` does: run the board for a while, price its kernels on the words, tell."""

from __future__ import annotations

from dataclasses import replace

from firmware.nav.attitude.flags import METHOD_NAMES
from host.cli.exit_codes import EXIT_MET
from host.cli.output_files import check_files, for_people, write_json
from host.cli.table_run import chosen
from host.cli.terminal import print_section
from host.compare.cost import PRICED, Cost, cost_of
from host.compare.cost_page import kinds_section, methods_section, section, to_dict
from host.compare.source import from_run
from host.compare.word_stream import bursts_of
from host.record.result import RunRequest
from host.tables.board_run import BOARD
from host.tables.coning_page import NAMES

RESULT_FORMAT = "navtwin-cycle-table-1"
FLIGHT = "duration_s=30"
"""Of the board's flight: standing, take-off, climb."""


def show_cycles(arithmetic: str, updates: bool, json_file: str | None, quiet: bool) -> int:
    """Returns the exit code. Raises UserError."""
    arithmetics = chosen("--arithmetic", arithmetic, PRICED)
    check_files(("--json", json_file))
    others: list[Cost] = []
    request = RunRequest(BOARD, scenario="flight", profile=arithmetics[0], overrides=(FLIGHT,))
    with from_run(request) as source:
        bursts = list(bursts_of(source.capture))
        plain, compensated = (replace(source.config, drift_compensation=on) for on in (False, True))
        asked = [(one, config) for one in arithmetics for config in (plain, compensated)]
        costs = [cost_of(*one, bursts) for one in asked]
        if updates:
            configs = [replace(plain, method=method) for method in METHOD_NAMES]
            others = [cost_of(one, config, bursts) for config in configs for one in arithmetics]
    console = for_people(json_file)
    if not quiet:
        print_section(console, section(costs))
        print_section(console, kinds_section(costs))
        if others:
            print_section(console, methods_section(others, NAMES))
    about = {"format": RESULT_FORMAT, "arithmetics": [to_dict(one) for one in costs]}
    write_json(about | {"updates": [to_dict(one) for one in others]}, json_file)
    return EXIT_MET
