"""Does the inertial unit's clock agree with the board's? Its counter against the times of its samples.

Navigation goes on with it, since increments are what they are; but a clock so far off is about to fail.
"""

from __future__ import annotations

from firmware.apps.dual_antenna.exchange import Exchange
from firmware.apps.gnss_ins.output import Output
from firmware.drivers import serial_imu_frames as fr

PERIOD_NS = 5_000_000
WINDOW = 200
"""Samples from one look to the next, at least."""
BAD_PPM = 1_000
"""Twenty times what a crystal is off by; the time of a sample is good to 50 µs, so a window to 100 ppm."""
GOOD_PPM = 800
MILLION = 1_000_000
LOOKS = 3
"""In a row that agree: a unit that was switched off counts from zero."""


class ImuClock:
    """Looked at from the background."""

    def __init__(self, exchange: Exchange, output: Output) -> None:
        self._exchange = exchange
        self._output = output
        self._begin = (0, 0)
        self._is_bad = False
        self._looks = 0

    def look(self) -> None:
        """Say what has changed."""
        counter, end_ns = self._exchange.counted
        samples = (counter - self._begin[0]) & fr.COUNTER_MASK
        if samples < WINDOW:
            return
        passed_ns = end_ns - self._begin[1]
        self._begin = counter, end_ns
        if passed_ns <= 0:
            return
        ppm = round((samples * PERIOD_NS / passed_ns - 1.0) * MILLION)
        bad = abs(ppm) > (GOOD_PPM if self._is_bad else BAD_PPM)
        self._looks = 0 if bad == self._is_bad else self._looks + 1
        if self._looks == LOOKS:
            self._is_bad, self._looks = bad, 0
            self._output.send_text(f"IMU clock {ppm:+d} ppm off" if bad else "IMU clock is good again")
