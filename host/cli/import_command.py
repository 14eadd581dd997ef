"""`navtwin import`: recordings of other programs as captures."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from host.cli.exit_codes import NOTHING_WRITTEN, guarded

KIND_HELP = "ubx, nmea, can, kf-gins, csv, comma2k19 or broad."


def import_command(
    kind: Annotated[str, typer.Argument(metavar="KIND", help=KIND_HELP)],
    files: Annotated[
        list[str],
        typer.Argument(metavar="FILE...", help="imu=FILE, gnss=FILE, truth=FILE say which is which."),
    ],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FILE", help="The new capture.")],
    mapping: Annotated[
        Path | None, typer.Option("--map", metavar="FILE", help="csv: which columns mean what.")
    ] = None,
    dbc: Annotated[
        Path | None, typer.Option("--dbc", metavar="FILE", help="can: decode signals by this database.")
    ] = None,
    unit: Annotated[
        list[str] | None,
        typer.Option(
            "--unit", metavar="QUANTITY=UNIT", help="State a unit, e.g. gyro=deg/s. May be repeated."
        ),
    ] = None,
    leap_seconds: Annotated[
        int | None, typer.Option("--leap-seconds", metavar="N", min=0, max=60, help="Default: by the date.")
    ] = None,
    week: Annotated[
        int | None, typer.Option("--week", metavar="N", min=0, max=9999, help="kf-gins: the GPS week.")
    ] = None,
    date: Annotated[
        str | None,
        typer.Option("--date", metavar="YYYY-MM-DD", help="nmea, ubx: of the first sentence with a time."),
    ] = None,
    geoid_separation: Annotated[
        float | None,
        typer.Option(
            "--geoid-separation", metavar="M", min=-150.0, max=150.0, help="nmea: where sentences tell none."
        ),
    ] = None,
    accuracy: Annotated[
        str | None,
        typer.Option(
            "--accuracy",
            metavar="H,V,S",
            help="1 sigma of the receiver's position (m, m) and velocity (m/s), where it tells none.",
        ),
    ] = None,
    json: Annotated[
        str | None,
        typer.Option("--json", metavar="FILE|-", help="What was found, as JSON; - is standard output."),
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress, no tables.")] = False,
) -> None:
    """Make a capture of a recording, and tell what is wrong with it.

    Ends with 0 also when something was found; with 2 when nothing could be made of it, or when a unit is
    certainly another one than named (--unit states the right one).
    """

    def command() -> int:
        from host.cli.import_run import Wanted, execute

        wanted = Wanted(
            kind,
            tuple(files),
            output,
            mapping,
            dbc,
            tuple(unit or ()),
            leap_seconds,
            week,
            date,
            geoid_separation,
            accuracy,
        )
        return execute(wanted, json, quiet)

    guarded(command, NOTHING_WRITTEN)
