"""`navtwin allan`: the noise of inertial samples at rest."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from host.cli.exit_codes import guarded
from host.cli.simulate_command import NOTHING_KEPT


def allan_command(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="Samples at rest: .npz, .csv or .txt of navtwin simulate.")
    ],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="FILE", help="A page with the curves (HTML).")
    ] = None,
    preset: Annotated[
        str | None, typer.Option("--preset", metavar="NAME", help="Show what this error preset sets beside.")
    ] = None,
    json: Annotated[
        str | None, typer.Option("--json", metavar="FILE|-", help="Coefficients and curves in SI.")
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No tables.")] = False,
) -> None:
    """Overlapping Allan deviation of every axis, by allantools, and the noise coefficients in it."""

    def command() -> int:
        from host.cli.allan_run import execute

        return execute(file, output, preset, json, quiet)

    guarded(command, NOTHING_KEPT)
