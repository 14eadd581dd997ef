"""`navtwin proof`: the simulator's figures beside its document's."""

from __future__ import annotations

from typing import Annotated

import typer

from host.cli.exit_codes import guarded
from host.cli.simulate_command import NOTHING_KEPT


def proof_command(
    parts: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[PART]...",
            help="closure, independent, closed-forms, joints, noise, bmi160, drift, speed. Default: all.",
        ),
    ] = None,
    json: Annotated[
        str | None, typer.Option("--json", metavar="FILE|-", help="Figures as JSON; - is standard output.")
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No table.")] = False,
) -> None:
    """Measure the sensor simulator anew, and put its figures beside those of the document and the limits.

    All of it takes three to four minutes. Ends with 1 when a figure misses its limit.
    """

    def command() -> int:
        from host.cli.proof_run import execute

        return execute(tuple(parts or ()), json, quiet)

    guarded(command, NOTHING_KEPT)
