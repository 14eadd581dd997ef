"""One lane for each arithmetic: the board's attitude computer as it is, fed with recorded bursts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firmware.apps.uav_ahrs.attitude import Attitude
from firmware.apps.uav_ahrs.kernels import AttitudeKernels
from firmware.apps.uav_ahrs.steps import READY
from firmware.nav.attitude import layout as at
from firmware.nav.attitude.config import AttitudeConfig
from firmware.nav.attitude.flags import SATURATION_NAMES
from host.compare.word_stream import Bursts

Integers = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Solutions:
    """What came of some bursts: after each that ended an iteration, a record; the others hold zeros."""

    made: NDArray[np.bool_]
    records: Integers
    """(bursts, OUT_SIZE), see `firmware.nav.attitude.layout`."""


class Lane:
    """One arithmetic on its way through the stream."""

    def __init__(self, arithmetic: str, config: AttitudeConfig) -> None:
        self.arithmetic = arithmetic
        self.iterations = 0
        self._attitude = Attitude(AttitudeKernels(arithmetic, config.drift_compensation), config)

    def take(self, bursts: Bursts) -> Solutions:
        """Go on by some bursts."""
        one = self._attitude
        made = np.zeros(len(bursts), np.bool_)
        records = np.zeros((len(bursts), at.OUT_SIZE), np.int64)
        for place, raw in enumerate(bursts.raw):
            if one.take_burst(one.s, one.i, one.k, raw, one.burst_words) & READY and one.iterate():
                made[place] = True
                records[place] = one.solve()
        self.iterations += int(made.sum())
        return Solutions(made, records)

    def saturations(self) -> dict[str, int]:
        """How often each kind of quantity met its limit."""
        return dict(zip(SATURATION_NAMES, self._attitude.saturations(), strict=True))
