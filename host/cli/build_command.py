"""`navtwin build`: an image for a processor from the kernels of a board."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from host.cli.exit_codes import NOTHING_WRITTEN, guarded
from host.cli.run_options import BoardName, Figures, ProfileName


def build_command(
    board: BoardName,
    target: Annotated[str, typer.Option("--target", metavar="CHIP", help="stm32f405.")] = "stm32f405",
    profile: ProfileName = None,
    out: Annotated[
        Path, typer.Option("--out", metavar="DIR", help="Folder of the files; made when it is missing.")
    ] = Path("build"),
    json: Figures = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No table.")] = False,
) -> None:
    """Compile the navigation kernels of a board for a Cortex-M4F: ELF, HEX and BIN with a serial monitor.

    Flash it and compare it with the twin: navtwin pil BOARD --port /dev/ttyUSB0.
    """

    def command() -> int:
        from host.cli.build_run import execute

        return execute(board, target, profile, out, json, quiet)

    guarded(command, NOTHING_WRITTEN)
