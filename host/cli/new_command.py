"""`navtwin new board`: the beginning of a board of one's own."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from host.cli.exit_codes import guarded

app = typer.Typer(
    help="Begin something of your own, outside this repository.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


@app.callback()
def _group() -> None:
    """Begin something of your own, outside this repository."""


@app.command("board")
def board_command(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Lower-case letters, digits and _.")],
    folder: Annotated[
        Path | None,
        typer.Option("--dir", metavar="DIR", help="The repository it goes into. Default: a new folder NAME."),
    ] = None,
) -> None:
    """Write a small working board: description, firmware, scenarios, tests, CI.

    Nothing that is there already is overwritten.
    """

    def command() -> int:
        from host.cli.exit_codes import EXIT_MET
        from host.new_board.writing import write_board

        place = folder if folder is not None else Path(name)
        written = write_board(name, place)
        for path in written:
            print(f"  {path}")
        print(f"{len(written)} files. Try it:  navtwin run {place}    More: {place / 'README.md'}")
        return EXIT_MET

    guarded(command)
