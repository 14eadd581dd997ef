"""Where two results of one call differ: kernel, state, both values, and how far apart they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from host.pil.digest import words_of
from host.pil.kernel_table import TargetKernel
from host.pil.state_names import state_name


@dataclass(frozen=True, slots=True)
class Difference:
    """The first difference of one call."""

    step: int
    """Number of the call, from 0."""
    kernel: str
    state: str
    """`f[4] VELOCITY`, or `result 1`."""
    twin: float
    target: float
    ulp: int
    """Units in the last place between them; for integers their difference."""
    elements: int
    """How many elements and results of this call differ."""

    def text(self) -> str:
        """In one line."""
        return (
            f"step {self.step}: {self.kernel}: {self.state}: twin {self.twin!r}, target {self.target!r},"
            f" {self.ulp} ULP apart ({self.elements} values of this call differ)"
        )


def first_difference(
    step: int,
    kernel: TargetKernel,
    names: Sequence[str],
    twin: Sequence[NDArray[Any]],
    target: Sequence[NDArray[Any]],
    twin_slots: Sequence[int],
    target_slots: Sequence[int],
) -> Difference:
    """Compare what the twin's call left with what the target's call left."""
    found: list[tuple[str, Any, Any]] = []
    elements = 0
    for name, ours, theirs in zip(names, twin, target, strict=True):
        places = _differing(ours, theirs)
        elements += len(places)
        if len(places) and not found:
            at = int(places[0])
            known = state_name(kernel.name.rpartition(".")[0], name, at)
            found.append((f"{name}[{at}]" + (f" {known}" if known else ""), ours[at], theirs[at]))
    for place, (mine, other) in enumerate(zip(twin_slots, target_slots, strict=True)):
        if mine != other:
            elements += 1
            found.append((f"result {place}" if place else "status", *_results(kernel, place, mine, other)))
    if not found:  # the digest differs, the memory does not: read wrongly, or the digest is
        return Difference(step, kernel.name, "digest only", 0, 0, 0, 0)
    state, ours, theirs = found[0]
    return Difference(
        step, kernel.name, state, ours.item(), theirs.item(), ulp_between(ours, theirs), elements
    )


def ulp_between(one: Any, other: Any) -> int:
    """Floats of the same type between two; integers: their difference."""
    if isinstance(one, np.floating):
        return abs(_ordered(one) - _ordered(other))
    return abs(int(one) - int(other))


def _ordered(value: Any) -> int:
    bits = int(np.float32(value).view(np.int32))
    return bits if bits >= 0 else -(bits & 0x7FFFFFFF)


def _differing(ours: NDArray[Any], theirs: NDArray[Any]) -> NDArray[np.intp]:
    """Elements whose bits differ, all NaN being one."""
    width = ours.dtype.itemsize
    if width < 4:
        return np.flatnonzero(ours != theirs)
    differ = words_of(ours) != words_of(theirs)
    return np.unique(np.flatnonzero(differ) * 4 // width)


def _results(kernel: TargetKernel, place: int, mine: int, other: int) -> tuple[Any, Any]:
    if place and kernel.signature.results[place - 1].scalar == "float32":
        bits = np.array([mine, other], np.uint32).view(np.float32)
        return bits[0], bits[1]
    signed = np.array([mine, other], np.uint64).view(np.int64)
    return signed[0], signed[1]
