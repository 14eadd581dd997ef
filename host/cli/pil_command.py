"""`navtwin pil`: the kernels of a board on a Cortex-M4F, compared with the twin's bit by bit."""

from __future__ import annotations

from typing import Annotated

import typer

from host.cli.exit_codes import NOTHING_WRITTEN, guarded, whole_number
from host.cli.run_options import BoardName, ChangesAsInRun, Data, Figures, ProfileName, ScenarioName, Seed


def pil_command(
    board: BoardName,
    scenario: ScenarioName = None,
    profile: ProfileName = None,
    seed: Seed = 1,
    changes: ChangesAsInRun = None,
    steps: Annotated[
        int, typer.Option("--steps", "-n", parser=whole_number, metavar="N", help="Kernel calls to compare.")
    ] = 10_000,
    port: Annotated[
        str | None,
        typer.Option(
            "--port",
            metavar="URL",
            help="Of a real board, /dev/ttyUSB0. Default: an emulated one.",
        ),
    ] = None,
    costs: Annotated[
        bool, typer.Option("--costs", help="Count the instructions of each kernel (slower).")
    ] = False,
    unit: Annotated[
        bool, typer.Option("--unit", help="Each kernel on its own, with random and extreme inputs.")
    ] = False,
    stand_alone: Annotated[
        bool,
        typer.Option(
            "--stand-alone",
            help="The image navigates by itself on raw frames of the twin's run; its solutions are compared.",
        ),
    ] = False,
    planted: Annotated[
        str | None,
        typer.Option(
            "--plant",
            metavar="NAME",
            help="Build a difference into the image to see it caught: fma, constant or rounding.",
        ),
    ] = None,
    data: Data = None,
    json: Figures = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Only the verdict.")] = False,
) -> None:
    """Compare the twin with a processor: the same kernels, the same inputs, every bit of the states.

    Without --port QEMU's netduinoplus2, an STM32F405, is started. Ends with 1 when a step differs.
    """

    def command() -> int:
        from host.cli.pil_run import Asked, execute
        from host.record.result import RunRequest

        run = RunRequest(board, scenario, profile, seed, tuple(changes or ()), data)
        return execute(Asked(run, steps, port, costs, unit, planted, stand_alone), json, quiet)

    guarded(command, NOTHING_WRITTEN)
