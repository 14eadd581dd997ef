"""Polls a chip on the desk in real time and keeps count: samples, losses, restarts, what the bridge did."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic
from typing import Any

import numpy as np

from hal.live.bridge_session import BridgeSession
from hal.live.cpu import LiveCpu
from host.attach.chip_on_desk import ChipOnDesk, Found
from host.attach.chip_statistics import SampleStatistics

CHECK_S = 1.0
RETRY_S = 0.5


class ChipSession:
    """One attachment, from `start` to `report`."""

    def __init__(self, chip: ChipOnDesk, cpu: LiveCpu, bridge: BridgeSession) -> None:
        self.chip = chip
        self.statistics = SampleStatistics(len(chip.quantities))
        self.state = Found(False, "not started")
        self.missed = self.restarts = 0
        self.temperature: float | None = None
        self._temperature_sum = 0.0
        self._temperatures = 0
        self._cpu = cpu
        self._bridge = bridge
        self._begin = self._now = monotonic()
        self._first_sample = self._last_sample = 0.0
        self._exchanges_before = 0
        self._check_at = self._retry_at = 0.0
        self._unbroken = False
        """Whether the next sample follows the last one."""

    def start(self) -> Found:
        """Identify and set up the chip, once."""
        self.state = self.chip.start()
        return self.state

    def run(self, seconds: float | None, stop: Callable[[], bool]) -> None:
        """Poll until `seconds` are over or `stop`; another thread may look on."""
        self._begin = self._now = monotonic()
        self._exchanges_before = self._bridge.counters.exchanges
        self._check_at = self._begin + CHECK_S
        self._take_temperature()
        period = 1.0 / self.chip.polls_per_s
        due = self._begin
        while not stop() and (seconds is None or self.elapsed_s < seconds):
            alive = self._poll()
            well = alive and self.state.ok
            if self._now >= (self._check_at if well else self._retry_at):
                self._look()
            due = max(due + period, monotonic())
            self._cpu.delay(round((due - monotonic()) * 1e9))
            self._now = monotonic()
        self._now = monotonic()

    @property
    def elapsed_s(self) -> float:
        """Since `run` began."""
        return self._now - self._begin

    @property
    def rate_hz(self) -> float | None:
        """New samples a second."""
        span = self._last_sample - self._first_sample
        return (self.statistics.count + self.missed - 1) / span if span > 0.0 else None

    @property
    def clock_error(self) -> float | None:
        """How much the chip's clock is fast against this computer's, relative."""
        chip_s = self.chip.clock_s()
        span = self._last_sample - self._first_sample
        if chip_s is None or span <= 0.0 or self.restarts:
            return None
        return chip_s / span - 1.0

    @property
    def exchanges_per_s(self) -> float:
        """Transactions over the bridge."""
        exchanges = self._bridge.counters.exchanges - self._exchanges_before
        return exchanges / self.elapsed_s if self.elapsed_s > 0.0 else 0.0

    def report(self) -> dict[str, Any]:
        """All figures, for `--json`."""
        counters = self._bridge.counters
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
        now = monotonic()
        if not poll.alive:
            self._unbroken = False
            return False
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
        self._retry_at = self._now + RETRY_S
        self._check_at = self._now + CHECK_S
        self.state = self.chip.check()
        if self.state.ok:
            self._take_temperature()
            return
        self._unbroken = False
        again = self.chip.start()
        if again.ok:
            self.restarts += 1
            self.state = again

    def _take_temperature(self) -> None:
        self.temperature = self.chip.temperature()
        if self.temperature is not None:
            self._temperature_sum += self.temperature
            self._temperatures += 1


def _number(value: float, count: int) -> float | None:
    """None where there is no figure yet: JSON knows no NaN."""
    return float(value) if count and np.isfinite(value) else None
