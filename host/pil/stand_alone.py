"""A program's navigation loop in an image: its tables for firmware/target/loop.c."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.typing import NDArray

from boards.assembly import installation_of
from boards.description import Board
from firmware.drivers import gnss_epoch as gnss
from firmware.link.raw_frames import INPUTS, RAW_EPOCH
from firmware.link.stand_alone import StandAlone
from host.pil.kernel_table import TargetKernel
from host.record.errors import UserError
from host.run.intake import HOST_PORT

DOOR = "stand_alone"
"""Module beside the program's, and its function."""
NO_LOOP = '#include "loop.h"\nconst struct loop loop;\n'
VALUES_OF_HEAD = 3
"""Number of the input, count and time of the pulse, before the record of an EPOCH."""


def stand_alone_of(board: Board, profile: Mapping[str, Any]) -> StandAlone | None:
    """The loop of the program behind the board's host port; None when it has none. Raises UserError."""
    if HOST_PORT not in board.uarts:
        return None
    processor = board.uarts[HOST_PORT].processor
    package = board.processors[processor].program.partition(":")[0].rpartition(".")[0]
    if not package or find_spec(f"{package}.{DOOR}") is None:
        return None
    door: Callable[..., StandAlone] = getattr(import_module(f"{package}.{DOOR}"), DOOR)
    captures = [
        name
        for name, pin in board.pins.items()
        if pin.use == "capture" and pin.wired and pin.processor == processor
    ]
    try:
        return door(profile, installation_of(board), captures)
    except ValueError as error:
        raise UserError(f"board {board.name}: {error}") from None


def loop_source(loop: StandAlone | None, kernels: Sequence[TargetKernel]) -> str:
    """The generated source file; one without a loop for None."""
    if loop is None:
        return NO_LOOP
    words = np.concatenate([_words(loop.floats), _words(loop.integers)])
    lines = ['#include "loop.h"', ""]
    runs = list(_runs(words))
    for at, values in runs:
        numbers = ", ".join(f"0x{value:08X}u" for value in values.tolist())
        lines.append(f"static const uint32_t run_{at}[] = {{{numbers}}};")
    lines.append("static const struct loop_run runs[] = {")
    lines += [f"    {{{at}, {values.size}, run_{at}}}," for at, values in runs]
    lines += ["};", "const struct loop loop = {"]
    lines += [f"    .{name} = {value}," for name, value in _members(loop, kernels).items()]
    lines += ["    .runs = runs,", f"    .run_count = {len(runs)},", "};", ""]
    return "\n".join(lines)


def _members(loop: StandAlone, kernels: Sequence[TargetKernel]) -> dict[str, int | str]:
    numbers = {kernel.name: kernel.number for kernel in kernels}
    told = len(INPUTS[RAW_EPOCH].unpack(bytes(INPUTS[RAW_EPOCH].size))) - VALUES_OF_HEAD
    return {
        "floats": loop.floats.size,
        "integers": loop.integers.size,
        "record": gnss.RECORD_SIZE,
        "told": told,
        "each_sample": int(loop.each_sample),
        "steps": loop.steps,
        "sample": numbers[kernel_name(loop.sample)],
        "epoch": numbers[kernel_name(loop.epoch)],
        "temperature": numbers[kernel_name(loop.temperature)],
        "solution": numbers[kernel_name(loop.solution)],
        "clock_at": loop.clock.start,
        "clock_size": len(loop.clock),
        "solution_floats": loop.solution_floats,
        "solution_integers": loop.solution_integers,
        "flags": gnss.FLAGS,
        "time_of_day": gnss.TIME_OF_DAY_MS,
        "date": gnss.DATE_DAYS,
        "burst_start": gnss.BURST_START_NS,
        "valid": gnss.VALID_NS,
        "has_time": gnss.HAS_TIME,
        "nominal_latency_ns": f"{loop.nominal_latency_ns}ll",
        "longest_pulse_age_ns": f"{loop.longest_pulse_age_ns}ll",
    }


def kernel_name(kernel: Any) -> str:
    """Module and function."""
    function = kernel.py_func
    return f"{function.__module__}.{function.__qualname__}"


def _words(array: NDArray[Any]) -> NDArray[np.uint32]:
    return np.ascontiguousarray(array).view(np.uint32)


def _runs(words: NDArray[np.uint32]) -> Iterable[tuple[int, NDArray[np.uint32]]]:
    """(first word, words) of what is not zero."""
    places = np.flatnonzero(words)
    if places.size:
        for run in np.split(places, np.flatnonzero(np.diff(places) > 2) + 1):
            yield int(run[0]), words[run[0] : run[-1] + 1]
