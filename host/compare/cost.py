"""What the computations cost on the modelled processor: the board's own kernels, priced (`host.cycles`)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from firmware.apps.uav_ahrs.attitude import Attitude
from firmware.apps.uav_ahrs.kernels import AttitudeKernels
from firmware.apps.uav_ahrs.steps import READY
from firmware.nav.attitude.config import AttitudeConfig
from firmware.numerics.dialect import entries_named
from host.compare.word_stream import Bursts
from host.cycles.estimate import Cycles, PricedKernel
from host.record.errors import UserError

CLOCK_HZ = 150_000_000
DOCUMENT_S = 0.35e-3
"""Of one solution, as the document has it: 52,500 cycles."""
PRICED = ("float32", "fixed")
"""Arithmetics that fly; float64 would be in software."""
MOST = 2_500
"""Iterations that are priced, about."""


BURSTS = {"take_burst": 2}
"""Calls for one solution, of those that are called more than once."""


@dataclass(frozen=True, slots=True)
class Cost:
    """Mean cycles of each call of one arithmetic, with one update method."""

    arithmetic: str
    method: str
    compensated: bool
    """Whether the drift compensation is part of an iteration."""
    calls: dict[str, Cycles]
    """By the name of the entry kernel."""

    @property
    def solution(self) -> float:
        """Cycles from the words to the angles: two bursts, an iteration, the record."""
        return sum(one.per_call * BURSTS.get(name, 1) for name, one in self.calls.items())


def cost_of(arithmetic: str, config: AttitudeConfig, stream: Iterable[Bursts]) -> Cost:
    """Run the iterations of a stream, at most MOST, with priced kernels. Raises UserError without any."""
    kernels, priced = _priced_kernels(arithmetic, config.drift_compensation)
    one = Attitude(kernels, config)
    made = 0
    for some in stream:
        for raw in some.raw:
            if one.take_burst(one.s, one.i, one.k, raw, one.burst_words) & READY and one.iterate():
                one.solve()
                made += 1
        if made >= MOST:
            break
    if not made:
        raise UserError("no iteration to price: the alignment never ended; give some seconds of rest first")
    calls = {name: kernel.cycles() for name, kernel in priced.items()}
    return Cost(arithmetic, config.method, config.drift_compensation, calls)


def _priced_kernels(arithmetic: str, compensated: bool) -> tuple[AttitudeKernels, dict[str, PricedKernel]]:
    """Kernels whose entry points count what they cost, and those by name."""
    with entries_named():
        kernels = AttitudeKernels(arithmetic, compensated)
    priced: dict[str, PricedKernel] = {}
    for name, found in vars(kernels).items():
        if hasattr(found, "compile_declared"):
            priced[name] = PricedKernel(found.py_func.__module__, found.py_func.__name__)
            setattr(kernels, name, priced[name])
    return kernels, priced
