"""Everything compiled is ready before virtual time begins.

A board like the one that is to run is assembled in a world of its own, works for a second of virtual time
and is thrown away (20 ms): whatever it calls is then compiled, or loaded from the cache on disk, and nothing
of that falls into the run, where it would count as speed and could look like a firmware that hangs. And a
board that lacks what its program asks for is found before anything is written.

At the first run with the present sources most of the time would go into the kernels on board and the
simulator's loops. Therefore the entry kernels are asked for first, and a second process (a fork of this one)
takes them from the longest on while this one does the simulator and then the kernels from the shortest on.
Any other run that begins meanwhile takes its share instead of doing the same again (`claims`).
"""

from __future__ import annotations

import gc
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from boards.assembly import assemble
from boards.description import Board
from firmware.numerics.claims import claim
from firmware.numerics.dialect import INTERPRETED, entries_named, kept_file
from hal.emulated.can_frame import ends_of_sets
from host.record.row_text import RowText
from host.run.panel import panel_of
from host.run.setup import Setup
from host.run.surroundings import Surroundings
from host.sim.compiled import keep_code_of_chips
from host.sim.world import World

BOOT_NS = 1_000_000
"""By then a program has asked for its entry kernels and called hardly any."""
WORK_NS = 1_200_000_000
"""By then a receiver has sent its first epochs."""
BANDWIDTH_HZ = 40.0
FIRST_RUN = "compiling the on-board kernels (first run with these sources, some 15 s) …"

_warm: set[str] = set()
"""What this process has warmed up for."""


def warm_up(setup: Setup, another_world: Callable[[], World], notice: Callable[[str], None] | None) -> None:
    """Compile or load all that a run needs; `notice` is told when it takes long.

    Once for each board and profile in a process; `another_world` makes a world like that of the run.
    """
    key = repr((setup.board, setup.profile, setup.scenario.kind, setup.scenario.panel.mode))
    if key in _warm:
        return
    keep_code_of_chips()
    world = another_world()
    with entries_named() as kernels:
        board = assemble(setup.board, setup.profile, Surroundings(world, None))
        panel_of(board, setup.scenario.panel)
        board.machine.run_until(BOOT_NS)
    compile_missing(kernels, lambda: _exercise(setup.board, world), notice)
    _exercise(setup.board, world)
    board.machine.run_until(WORK_NS)
    board.machine.power_off()
    _warm.add(key)


def compile_missing(
    kernels: Sequence[Any], own_work: Callable[[], None], notice: Callable[[str], None] | None
) -> None:
    """Compile those of `kernels` that the cache lacks with `own_work` beside; nothing when it lacks none."""
    missing = [] if INTERPRETED else [kernel for kernel in dict.fromkeys(kernels) if _is_missing(kernel)]
    if missing:
        if notice is not None:
            notice(FIRST_RUN)
        missing.sort(key=_size, reverse=True)
        _compile_side_by_side(missing, own_work)


def _is_missing(kernel: Any) -> bool:
    file = kept_file(kernel)
    return file is None or not file.is_file()


def _size(kernel: Any) -> int:
    """How many kernels end in this one: about the time to compile it."""
    found: set[int] = set()
    waiting = [kernel]
    while waiting:
        function = waiting.pop().py_func
        for name in function.__code__.co_names:
            callee = function.__globals__.get(name)
            if hasattr(callee, "py_func") and id(callee) not in found:
                found.add(id(callee))
                waiting.append(callee)
    return len(found)


def _compile_side_by_side(kernels: Sequence[Any], own_work: Callable[[], None]) -> None:
    """`kernels`, longest first, and the work of the host, in two processes where the system forks well."""
    with _no_collector():
        folder = next((file.parent for file in map(kept_file, kernels) if file is not None), None)
        # A fork of a process with several threads may find locks that nobody will ever open.
        shared = folder is not None and sys.platform == "linux" and threading.active_count() == 1
        helper = _forked(lambda: _compile(kernels)) if shared else None
        try:
            with claim(folder / "host.claim", wait=True) if folder is not None else _nothing():
                own_work()
            _compile(kernels[::-1])
        finally:
            if helper is not None:
                os.kill(helper, signal.SIGTERM)
                os.waitpid(helper, 0)


def _compile(kernels: Sequence[Any]) -> None:
    """Each of the kernels that no other process is compiling; then those, which lie in the cache by then."""
    for wait in (False, True):
        for kernel in kernels:
            file = kept_file(kernel)
            with claim(file.with_suffix(".claim"), wait) if file is not None else _nothing() as ours:
                if ours:
                    kernel.compile_declared()


def _forked(work: Callable[[], None]) -> int:
    """A process that does `work`. Should it fail, this process will do the work and tell what is wrong."""
    process = os.fork()
    if process:
        return process
    try:
        nowhere = os.open(os.devnull, os.O_RDWR)
        os.dup2(nowhere, 1)
        os.dup2(nowhere, 2)
        work()
    finally:
        os._exit(0)


@contextmanager
def _nothing() -> Iterator[bool]:
    yield True


@contextmanager
def _no_collector() -> Iterator[None]:
    """A compiler makes many objects and few cycles: 8 % less time without looking for them."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def _exercise(description: Board, world: World) -> None:
    """Ask the world everything a run asks, for a hundredth of a second; write a number, time CAN frames."""
    times_ns = np.array([0, 10_000_000], dtype=np.int64)
    for refdes, chip in description.chips.items():
        if chip.world == "imu":
            world.imu(refdes, np.array(chip.mounting), np.array(chip.lever_arm_m), chip.errors).sample(
                times_ns, BANDWIDTH_HZ
            )
        elif chip.world == "gnss":
            second = None if chip.second_antenna_m is None else np.array(chip.second_antenna_m)
            world.gnss(refdes, np.array(chip.lever_arm_m), second).epoch(0)
    world.truth(times_ns)
    world.antenna_truth(times_ns, np.zeros(3))
    RowText.csv([3]).text(np.zeros((1, 1)))
    ends_of_sets(times_ns, (0,), bytes(16), 1)
