"""`navtwin baseline`: figures that later runs are held against."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from host.cli.exit_codes import guarded

app = typer.Typer(
    help="Figures that later runs and campaigns are held against (--baseline).",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


@app.callback()
def _group() -> None:
    """Figures that later runs and campaigns are held against (--baseline)."""


@app.command("update")
def update_command(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="The baseline; kept beside the sources.")],
    result: Annotated[
        Path, typer.Argument(metavar="RESULT", help="Folder of a finished run or campaign (its --out).")
    ],
) -> None:
    """Make or replace a baseline by the figures of a run or campaign."""

    def command() -> int:
        from host.baseline.update import update
        from host.cli.exit_codes import EXIT_MET

        print(update(file, result))
        return EXIT_MET

    guarded(command)
