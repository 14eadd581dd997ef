"""Options that say what is to run, the same in every command that runs a board."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from host.cli.exit_codes import whole_number

BoardName = Annotated[
    str, typer.Argument(metavar="BOARD", help="A board's name, or a folder with a board.toml.")
]
ScenarioName = Annotated[
    str | None, typer.Option("--scenario", "-s", metavar="NAME|FILE", help="Default: the board's own.")
]
ProfileName = Annotated[
    str | None, typer.Option("--profile", "-p", metavar="NAME", help="Default: the board's own.")
]
Seed = Annotated[
    int,
    typer.Option(
        "--seed", metavar="N", parser=whole_number, help="Of all noise; the same seed, the same bytes."
    ),
]
ChangesAsInRun = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Change one value, as in navtwin run."),
]
Data = Annotated[
    Path | None, typer.Option("--data", metavar="DIR", help="Real recordings. Default: NAVTWIN_DATA.")
]
Figures = Annotated[
    str | None, typer.Option("--json", metavar="FILE|-", help="All figures as JSON; - is standard output.")
]
NoCapture = Annotated[bool, typer.Option("--no-capture", help="Leave out run.mcap.")]
