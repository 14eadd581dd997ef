"""`navtwin boards`: what there is to run."""

from __future__ import annotations

import json
import sys
import tomllib
from pathlib import Path
from typing import Any

from boards.description import Board, load_board
from boards.places import board_folder, board_names
from boards.validation import DescriptionError
from host.cli.exit_codes import EXIT_BAD_INPUT, EXIT_MET


def list_boards(as_json: bool) -> int:
    """Print all boards, as a table or as JSON; what is wrong with one of them goes to standard error.

    Returns the exit code.
    """
    boards = []
    code = EXIT_MET
    for name in board_names():
        try:
            boards.append(_described(load_board(name), board_folder(name)))
        except DescriptionError as error:
            print(f"navtwin: {error}", file=sys.stderr)
            code = EXIT_BAD_INPUT
    if as_json:
        print(json.dumps(boards, indent=1))
    else:
        _print_tables(boards)
    return code


def _described(board: Board, folder: Path) -> dict[str, Any]:
    return {
        "name": board.name,
        "title": board.title,
        "processors": [
            {"name": name, "part": processor.part, "clock_hz": processor.clock_hz}
            for name, processor in board.processors.items()
        ],
        "chips": [{"refdes": refdes, "part": chip.part} for refdes, chip in board.chips.items()],
        "profiles": list(board.profiles),
        "default_profile": board.default_profile,
        "scenarios": [_scenario(path) for path in sorted((folder / "scenarios").glob("*.toml"))],
        "default_scenario": board.default_scenario,
    }


def _scenario(path: Path) -> dict[str, str]:
    """Name and description; a file that is wrong is told when it is run."""
    try:
        description = tomllib.loads(path.read_text(encoding="utf-8")).get("description", "")
    except ValueError:
        description = "(not valid TOML)"
    return {"name": path.stem, "description": str(description)}


def _print_tables(boards: list[dict[str, Any]]) -> None:
    from rich.console import Group
    from rich.table import Table
    from rich.text import Text

    from host.cli.terminal import standard_output

    console = standard_output()
    for board in boards:
        parts = Table.grid(padding=(0, 3))
        for processor in board["processors"]:
            clock = f"{processor['clock_hz'] / 1e6:g} MHz"
            parts.add_row("processor", processor["name"], f"{processor['part']}, {clock}")
        for chip in board["chips"]:
            parts.add_row("chip", chip["refdes"], chip["part"])
        for profile in board["profiles"]:
            default = "default" if profile == board["default_profile"] else ""
            parts.add_row("profile", profile, default)
        for scenario in board["scenarios"]:
            default = " (default)" if scenario["name"] == board["default_scenario"] else ""
            parts.add_row("scenario", scenario["name"], Text(scenario["description"] + default))
        heading = Text.assemble((board["name"], "bold"), f"  {board['title']}")
        console.print(Group(heading, parts), "")
    console.print("Run one:  navtwin run car_mems --scenario town")
