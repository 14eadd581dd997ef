"""`navtwin monitor`: a port, a capture or a board, live in the terminal."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from host.cli.exit_codes import guarded, whole_number


def monitor_command(
    what: Annotated[
        str,
        typer.Argument(
            metavar="PORT|CAPTURE|BOARD",
            help="/dev/ttyUSB0, socket://HOST:PORT, rfc2217://HOST:PORT; a capture or a run's folder; "
            "a board's name or folder.",
        ),
    ],
    baud: Annotated[
        int | None,
        typer.Option("--baud", metavar="N", help="Of a port. Default: the usual ones are tried.", min=50),
    ] = None,
    speed: Annotated[
        float | None,
        typer.Option(
            "--speed",
            metavar="K",
            min=0.0,
            help="Of a capture or board: 1 real time (default), 0 full speed.",
        ),
    ] = None,
    scenario: Annotated[
        str | None, typer.Option("--scenario", "-s", metavar="NAME|FILE", help="Of a board, as navtwin run.")
    ] = None,
    profile: Annotated[
        str | None, typer.Option("--profile", "-p", metavar="NAME", help="Of a board, as navtwin run.")
    ] = None,
    seed: Annotated[
        int | None, typer.Option("--seed", metavar="N", parser=whole_number, help="Of a board; default 1.")
    ] = None,
    changes: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Of a board, as navtwin run. May be repeated."),
    ] = None,
    data: Annotated[
        Path | None, typer.Option("--data", metavar="DIR", help="Real recordings. Default: NAVTWIN_DATA.")
    ] = None,
    once: Annotated[
        bool,
        typer.Option(
            "--once",
            "--plain",
            help="One picture as text, after --seconds; so it is, too, when the output is no terminal.",
        ),
    ] = False,
    json: Annotated[
        bool, typer.Option("--json", help="A line of JSON each second of the source's time; with --once one.")
    ] = False,
    seconds: Annotated[
        float | None,
        typer.Option(
            "--seconds",
            metavar="N",
            min=0.0,
            help="End after so much of the source's time. Default: never; with --once 6 of a port, 60 of a"
            " board, all of a capture.",
        ),
    ] = None,
    size: Annotated[
        str | None, typer.Option("--size", metavar="WxH", help="Of the picture of --once, e.g. 120x40.")
    ] = None,
) -> None:
    """Show live what a board says: attitude, position, track, satellites, health, load.

    A port may carry our link or a plain receiver (NMEA, UBX): that shows by itself. Keys: q quit, space
    pause, arrows 10 s back or on, + and - speed.
    """

    def command() -> int:
        from host.cli.monitor_run import MonitorRequest, monitor

        request = MonitorRequest(
            what=what,
            baud=baud,
            speed=speed,
            scenario=scenario,
            profile=profile,
            seed=seed,
            overrides=tuple(changes or ()),
            data_dir=data,
        )
        return monitor(request, once=once, as_json=json, seconds=seconds, size=size)

    guarded(command)
