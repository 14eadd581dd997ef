"""Polls a chip on the desk and keeps count: samples, losses, restarts, what the bridge did.

Which transactions come in which order depends on what the chip answers and on nothing else, so that a
record of them can take the chip's place.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from hal.live.bridge_session import BridgeCounters
from host.attach.chip_on_desk import ChipOnDesk, Found
from host.attach.chip_pace import Pace
from host.attach.chip_statistics import SampleStatistics

CHECK_S = 1.0
RETRY_S = 0.5
GONE = Found(False, "the bus reads as if nobody were there", absent=True)


class ChipSession:
    """One attachment, from `start` to `report`."""

    def __init__(self, chip: ChipOnDesk, pace: Pace, counters: BridgeCounters) -> None:
        self.chip = chip
        self.live = pace.live
        self.statistics = SampleStatistics(len(chip.quantities))
        self.state = Found(False, "not started")
        self.started = False
        """Whether the first set-up has come to an end, good or bad."""
        self.missed = self.restarts = 0
        self.temperature: float | None = None
        self._temperature_sum = 0.0
        self._temperatures = 0
        self._pace = pace
        self._counters = counters
        self._begin = self._now = pace.now()
        self._first_sample = self._last_sample = 0.0
        self._exchanges_before = 0
        self._polls_to_check = self._polls_to_retry = 0
        self._unbroken = False
        """Whether the next sample follows the last one."""

    def start(self) -> Found:
        """Identify and set up the chip, once."""
        self.state = self.chip.start()
        self.started = True
        return self.state

    def run(self, seconds: float | None, stop: Callable[[], bool]) -> None:
        """Poll until `seconds` are over or `stop`; another thread may look on."""
        pace = self._pace
        self._begin = self._now = due = pace.now()
        self._exchanges_before = self._counters.exchanges
        self._polls_to_check = self._polls(CHECK_S)
        self._take_temperature()
        period = 1.0 / self.chip.polls_per_s
        while not (stop() or pace.is_over()) and (seconds is None or self.elapsed_s < seconds):
            alive = self._poll()
            self._polls_to_check -= 1
            self._polls_to_retry -= 1
            well = alive and self.state.ok
            if (self._polls_to_check if well else self._polls_to_retry) <= 0:
                self._look()
            due = max(due + period, pace.now())
            pace.wait_until(due)
            self._now = pace.now()

    @property
    def elapsed_s(self) -> float:
        """Since `run` began."""
        return self._now - self._begin

    @property
    def rate_hz(self) -> float | None:
        """New samples a second; a record does not tell."""
        span = self._last_sample - self._first_sample
        return (self.statistics.count + self.missed - 1) / span if self.live and span > 0.0 else None

    @property
    def clock_error(self) -> float | None:
        """How much the chip's clock is fast against this computer's, relative."""
        chip_s = self.chip.clock_s()
        span = self._last_sample - self._first_sample
        if not self.live or chip_s is None or span <= 0.0 or self.restarts:
            return None
        return chip_s / span - 1.0

    @property
    def exchanges_per_s(self) -> float:
        """Transactions over the bridge."""
        exchanges = self._counters.exchanges - self._exchanges_before
        return exchanges / self.elapsed_s if self.elapsed_s > 0.0 else 0.0

    def report(self) -> dict[str, Any]:
        """All figures, for `--json`."""
        counters = self._counters
        statistics = self.statistics
        return {
            "ok": self.state.ok,
            "found": self.state.text,
            "seconds": self.elapsed_s,
            "samples": statistics.count,
            "samples_missed": self.missed,
            "rate_hz": self.rate_hz,
            "clock_error": self.clock_error,
            "temperature_c": self._temperature_sum / self._temperatures if self._temperatures else None,
            "restarts": self.restarts,
            "bridge": {
                "exchanges": counters.exchanges,
                "exchanges_per_s": self.exchanges_per_s,
                "failures": counters.failures,
                "recoveries": counters.recoveries,
                "last_problem": counters.last_problem,
            },
            "quantities": [
                {
                    "name": quantity.name,
                    "unit": quantity.unit,
                    "mean": _number(statistics.mean[at] * quantity.factor, statistics.count),
                    "noise": _number(statistics.noise[at] * quantity.factor, statistics.count),
                    "lowest": _number(statistics.lowest[at] * quantity.factor, statistics.count),
                    "highest": _number(statistics.highest[at] * quantity.factor, statistics.count),
                }
                for at, quantity in enumerate(self.chip.quantities)
            ],
        }

    def _poll(self) -> bool:
        poll = self.chip.poll()
        now = self._pace.now()
        if not poll.alive:
            self._unbroken = False
            if self.state.ok:
                self.state = GONE
            return False
        if not self.state.ok:  # it may have lost its settings: no sample counts until it was set up again
            return True
        self.missed += poll.missed
        follows = self._unbroken and not poll.missed
        for sample in poll.samples:
            if not self.statistics.count:
                self._first_sample = now
            self.statistics.add(sample, follows)
            self._last_sample = now
            self._unbroken = follows = True
        return True

    def _look(self) -> None:
        """Once a second, and often while something is wrong: start it again as the firmware would."""
        self._polls_to_retry = self._polls(RETRY_S)
        self._polls_to_check = self._polls(CHECK_S)
        self.state = self.chip.check()
        if self.state.ok:
            self._take_temperature()
            return
        self._unbroken = False
        again = self.chip.start()
        if again.ok:
            self.restarts += 1
            self.state = again

    def _polls(self, seconds: float) -> int:
        return max(1, round(seconds * self.chip.polls_per_s))

    def _take_temperature(self) -> None:
        self.temperature = self.chip.temperature()
        if self.temperature is not None:
            self._temperature_sum += self.temperature
            self._temperatures += 1


def _number(value: float, count: int) -> float | None:
    """None where there is no figure yet: JSON knows no NaN."""
    return float(value) if count and np.isfinite(value) else None
