"""`navtwin replay`: a capture again through the present firmware."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from host.cli.exit_codes import guarded


class Mode(StrEnum):
    """How a capture is replayed."""

    STRICT = "strict"
    PHYSICAL = "physical"


def replay_command(
    capture: Annotated[
        Path, typer.Argument(metavar="CAPTURE", help="run.mcap, run.mcap.part, or the folder of a run.")
    ],
    board: Annotated[
        str | None, typer.Option("--board", "-b", metavar="NAME|DIR", help="Default: the recorded one.")
    ] = None,
    profile: Annotated[
        str | None, typer.Option("--profile", "-p", metavar="NAME", help="Default: the recorded one.")
    ] = None,
    mode: Annotated[
        Mode,
        typer.Option(
            help="strict: all transactions must repeat; physical: chips feel the recorded quantities."
        ),
    ] = Mode.STRICT,
    changes: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="KEY=VALUE",
            help="physical: change one value of the board (board.pins.timepulse.wired=false), the profile"
            " (profile.gnss_rate_hz=5) or the scenario (gnss.latency_s=0.1). May be repeated.",
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="physical: report, solution and capture of the replay."),
    ] = None,
    json: Annotated[
        str | None,
        typer.Option("--json", metavar="FILE|-", help="The outcome as JSON; - is standard output."),
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress, no tables.")] = False,
) -> None:
    """Run a capture again through the present firmware.

    strict: the buses are answered from the capture, and everything the firmware does must repeat; the first
    difference is shown, and ends the replay with 1. physical: another profile or board on the same road.
    """

    def command() -> int:
        from host.cli.replay_run import Outputs, replay_physically, replay_strictly
        from host.replay.request import ReplayRequest

        request = ReplayRequest(capture, board, profile, out, overrides=tuple(changes or ()))
        outputs = Outputs(json, quiet)
        strict = mode is Mode.STRICT
        return replay_strictly(request, outputs) if strict else replay_physically(request, outputs)

    guarded(command)
