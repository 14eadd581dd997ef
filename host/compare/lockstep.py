"""Several arithmetics in lockstep on one stream of bus words."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from firmware.nav.attitude.config import AttitudeConfig
from host.compare.difference import Difference
from host.compare.lanes import Lane
from host.compare.word_stream import Bursts
from host.record.errors import UserError

REFERENCE = "float64"
GOAL_DEG = 0.01
"""RMS of the attitude difference between `fixed` and `float64`."""


@dataclass(frozen=True)
class Comparison:
    """What a comparison found."""

    reference: str
    differences: tuple[Difference, ...]
    """Of each other arithmetic."""
    saturations: dict[str, dict[str, int]]
    iterations: dict[str, int]
    compensated: bool
    """Whether the board's drift compensation was on."""
    bursts: int
    begin_s: float
    end_s: float
    """Of the stream, virtual time."""

    @property
    def met(self) -> bool | None:
        """Whether `fixed` stays within the goal; None: it was not compared with `float64`."""
        if self.reference != REFERENCE:
            return None
        found = [one.rms["attitude"] for one in self.differences if one.arithmetic == "fixed"]
        return bool(found[0] <= GOAL_DEG) if found else None


def reference_of(arithmetics: Sequence[str]) -> str:
    """Which one the others are measured against: float64, or else the last one named."""
    return REFERENCE if REFERENCE in arithmetics else arithmetics[-1]


def compare(
    arithmetics: Sequence[str],
    config: AttitudeConfig,
    stream: Iterable[Bursts],
    progress: Callable[[float], None] | None = None,
) -> Comparison:
    """Every arithmetic gets every burst. Raises UserError when nothing came of them."""
    reference = reference_of(arithmetics)
    compensated = config.drift_compensation
    lanes = {name: Lane(name, config) for name in arithmetics}
    others = [Difference(name, reference) for name in arithmetics if name != reference]
    bursts, begin_s, end_s = 0, 0.0, 0.0
    for some in stream:
        times_s = some.times_ns.astype(np.float64) * 1e-9
        begin_s = begin_s if bursts else float(times_s[0])
        end_s, bursts = float(times_s[-1]), bursts + len(some)
        made = {name: lane.take(some) for name, lane in lanes.items()}
        for difference in others:
            one, other = made[difference.arithmetic], made[reference]
            both = one.made & other.made
            difference.only_one += int(np.sum(one.made ^ other.made))
            difference.add(times_s[both], one.records[both], other.records[both])
        if progress is not None:
            progress(end_s)
    for difference in others:
        difference.finish()
        if not difference.count:
            raise UserError(
                f"{difference.arithmetic} and {reference} made no iteration together in {bursts} bursts: the"
                " alignment never ended; give a stream with some seconds of rest at the beginning"
            )
    saturations = {name: lane.saturations() for name, lane in lanes.items()}
    iterations = {name: lane.iterations for name, lane in lanes.items()}
    return Comparison(reference, tuple(others), saturations, iterations, compensated, bursts, begin_s, end_s)
