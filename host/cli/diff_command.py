"""`navtwin diff`: two captures or runs held against each other."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from host.cli.exit_codes import guarded


def diff_command(
    first: Annotated[Path, typer.Argument(metavar="A", help="A capture, or the folder of a run.")],
    second: Annotated[Path, typer.Argument(metavar="B", help="Another one.")],
    json: Annotated[
        str | None, typer.Option("--json", metavar="FILE|-", help="The same as JSON; - is standard output.")
    ] = None,
) -> None:
    """Compare two captures or runs: where they part, and how far their solutions drift.

    Ends with 0: nothing differs, 1: something does, 2: bad input.
    """

    def command() -> int:
        from host.cli.diff_run import show_difference

        return show_difference(first, second, json)

    guarded(command)
