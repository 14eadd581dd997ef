"""Everything compiled is ready before virtual time begins.

At the first run with the present sources the on-board kernels are compiled by two further processes, which
leave them in the cache on disk, while this one does the simulator's; later all of it is only loaded. Nothing
is compiled inside virtual time, where it would count as speed and could look like a firmware that hangs.

    python -m host.run.warm_up MODULE apps|others     what such a process does
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

import numpy as np

from boards.description import Board
from firmware.numerics.dialect import INTERPRETED, Kernel, kernels_are_kept, registered_kernels
from host.sim.world import World

PARTS = ("apps", "others")
"""The kernels of the program itself, which pull in the strapdown; and those of filter, drivers and link.
About equally long."""
BANDWIDTH_HZ = 40.0
FIRST_RUN = "compiling the on-board kernels (first run with these sources, some 15 s) …"


def warm_up(board: Board, world: World, notice: Callable[[str], None] | None) -> None:
    """Compile or load all kernels that `board` in `world` needs; `notice` is told when it takes long.

    `world` must be one of its own: it is asked for samples.
    """
    modules = sorted({processor.program.partition(":")[0] for processor in board.processors.values()})
    helpers: list[subprocess.Popen[bytes]] = []
    if not INTERPRETED and not kernels_are_kept():
        if notice is not None:
            notice(FIRST_RUN)
        helpers = [_helper(module, part) for module in modules for part in PARTS]
    try:
        _exercise(board, world)
        for helper in helpers:
            helper.wait()
    finally:
        for helper in helpers:
            helper.kill()
    for module in modules:
        _compile(module, PARTS)


def _helper(module: str, part: str) -> subprocess.Popen[bytes]:
    """A process that compiles one part; if it fails, this process compiles the part itself."""
    paths = [str(Path(__file__).parents[2]), *sys.path]
    return subprocess.Popen(
        [sys.executable, "-m", "host.run.warm_up", module, part],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(path for path in paths if path)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


def _compile(module: str, parts: tuple[str, ...]) -> None:
    """Compile what a program's kernels with a signature need, unless it lies in the cache."""
    try:
        import_module(module)
    except ImportError:
        return  # the board's loader tells it better
    for kernel in registered_kernels():
        if kernel.signature is not None and _part(kernel) in parts:
            compile_declared = getattr(kernel.callable, "compile_declared", None)
            if compile_declared is not None:
                compile_declared()


def _part(kernel: Kernel) -> str | None:
    """Inner kernels of arithmetic and conversion are compiled into those that call them."""
    if kernel.name.startswith("firmware.apps."):
        return "apps"
    return None if kernel.name.startswith("firmware.numerics.") else "others"


def _exercise(board: Board, world: World) -> None:
    """Ask the world everything a run asks, for a hundredth of a second."""
    times_ns = np.array([0, 10_000_000], dtype=np.int64)
    for refdes, chip in board.chips.items():
        if chip.world == "imu":
            world.imu(refdes, np.array(chip.mounting), np.array(chip.lever_arm_m), chip.errors).sample(
                times_ns, BANDWIDTH_HZ
            )
        elif chip.world == "gnss":
            world.gnss(refdes, np.array(chip.lever_arm_m)).epoch(0)
    world.truth(times_ns)
    world.antenna_truth(times_ns, np.zeros(3))


if __name__ == "__main__":
    _compile(sys.argv[1], (sys.argv[2],))
