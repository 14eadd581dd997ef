"""The measurements of run mode on the chip's own clock, worked off when somebody asks."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from boards.chips.hmc6343.compass import magnetometer_counts
from boards.chips.oscillator import Oscillator
from boards.chips.world import CompassWorld

RATES_HZ = {0x00: 1, 0x01: 5, 0x02: 10}
"""Of OP mode 2."""
SECOND = 1_000_000_000
_LONGEST_BLOCK = 4_096
FORESEEN_S = 5

_MINIMUM_SPAN = 1_000.0
"""Counts (100 mgauss) that an axis must have seen in a calibration, else its offset stays."""

_FIELD = slice(3, 6)


class Measurements:
    """The newest measurements, and the extremes of the field while a calibration runs."""

    def __init__(self, world: CompassWorld, error_ppb: int) -> None:
        self._world = world
        self._error_ppb = error_ppb
        self._foresee: Callable[[NDArray[np.int64]], None] | None = getattr(world, "foresee", None)
        self._foreseen = 0
        """Up to this measurement the world knows when it will be asked."""
        self._clock: Oscillator | None = None
        self._done = 0
        self.until_ns = 0
        """Nothing new is measured before."""
        self.rate_hz = 5
        self.rows: deque[list[float]] = deque(maxlen=1)
        """Force, field, temperature; the newest last."""
        self._low: NDArray[np.float64] | None = None
        self._high = np.zeros(3)

    def reset(self, rate_hz: int, depth: int) -> None:
        """Nothing measured yet; `depth` measurements are kept."""
        self._clock = None
        self.until_ns = 0
        self.rate_hz = rate_hz
        self.rows = deque(maxlen=depth)
        self._low = None

    @property
    def running(self) -> bool:
        """Run mode."""
        return self._clock is not None

    def start(self, first_ns: int) -> None:
        """Measure from `first_ns` on; until then the newest measurement still shows."""
        period = Oscillator(self.rate_hz, 0, self._error_ppb).instant(1)
        self._clock = Oscillator(self.rate_hz, first_ns - period, self._error_ppb)
        self._done = self._foreseen = 0
        self.until_ns = 0

    def set_clock_error(self, time_ns: int, error_ppb: int) -> None:
        """Another error of the clock from now on."""
        self.advance(time_ns)
        self._error_ppb = error_ppb
        self.until_ns = 0
        if self._clock is not None:
            self._clock.pull(time_ns, self.rate_hz, error_ppb)
            self._foreseen = 0

    def stop(self, time_ns: int) -> None:
        """No more measurements."""
        self.advance(time_ns)
        self._clock = None

    def next_ns(self, time_ns: int) -> int | None:
        """When the first measurement after `time_ns` is stored."""
        clock = self._clock
        return None if clock is None else clock.instant(clock.tick(time_ns) + 1)

    def advance(self, time_ns: int) -> bool:
        """Take the measurements up to a time: all while a calibration runs, else those that are kept.

        Tells whether `rows` may have changed."""
        clock = self._clock
        if clock is None or time_ns < self.until_ns:
            return False
        tick = clock.tick(time_ns)
        self.until_ns = clock.instant(tick + 1)
        if self._low is None:
            assert self.rows.maxlen is not None
            self._done = max(self._done, tick - self.rows.maxlen)
        while self._done < tick:
            count = min(tick - self._done, _LONGEST_BLOCK)
            if count == 1 and self._done >= self._foreseen and self._foresee is not None:
                self._foreseen = self._done + FORESEEN_S * self.rate_hz
                self._foresee(clock.grid(self._done + 1, 1, FORESEEN_S * self.rate_hz))
            values = self._world.sample(self._instants(clock, count))
            if not self._done:
                self.rows.clear()  # the filter begins anew
            self._done += count
            self.rows.extend(values.tolist())
            if self._low is not None:
                counts = magnetometer_counts(values[:, _FIELD])
                self._low = np.minimum(self._low, np.min(counts, axis=0))
                self._high = np.maximum(self._high, np.max(counts, axis=0))
        return True

    def _instants(self, clock: Oscillator, count: int) -> NDArray[np.int64]:
        """Of the next measurements."""
        if count == 1:
            return np.array([clock.instant(self._done + 1)], np.int64)
        return clock.grid(self._done + 1, 1, count)

    # -- calibration -------------------------------------------------------------------------------

    @property
    def calibrating(self) -> bool:
        """Between entering and leaving a calibration."""
        return self._low is not None

    def enter_calibration(self, time_ns: int) -> None:
        """Watch the field from now on."""
        self.advance(time_ns)
        self._low, self._high = np.full(3, np.inf), np.full(3, -np.inf)

    def exit_calibration(self, time_ns: int) -> list[int | None]:
        """The offsets that centre what was seen (counts); None for an axis that saw too little."""
        self.advance(time_ns)
        low, high = self._low, self._high
        assert low is not None
        self._low = None
        return [
            -round((high[axis] + low[axis]) / 2.0) if high[axis] - low[axis] >= _MINIMUM_SPAN else None
            for axis in range(3)
        ]
