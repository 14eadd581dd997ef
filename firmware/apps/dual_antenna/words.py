"""What this board tells in words beside what all do: the inertial unit, the front end, where heading is from.

Trouble is said when it begins and when it is over; about a disturbed line at most every AGAIN_NS.
"""

from __future__ import annotations

import math

from firmware.apps.dual_antenna.exchange import Exchange
from firmware.apps.dual_antenna.front_end_news import FrontEndNews
from firmware.apps.dual_antenna.imu_clock import ImuClock
from firmware.apps.dual_antenna.navigation import Navigation
from firmware.apps.gnss_ins.output import Output
from firmware.apps.gnss_ins.pulse_watch import PulseWatch
from firmware.drivers import serial_imu_frames as fr
from firmware.nav import flags as fl
from firmware.nav import reference_report as report

SILENT_LOOKS = 3
"""Looks without a sample after which the unit is called silent, without a clock the front end."""
START_LOOKS = 10
"""At the start it has so many more."""
AGAIN_NS = 10_000_000_000
GOOD_LOOKS = 30
COMPASS_EVERY_NS = 30_000_000_000
YAW_SOURCES = ("none", "as given", "course", "baseline of the antennas", "gyro-compass")
DEGREES = 180.0 / math.pi
STATUS_WORDS = {
    fr.SELF_TEST_FAILED: "IMU: self-test failed",
    fr.GYRO_RANGE: "IMU: rate beyond its range",
    fr.ACCEL_RANGE: "IMU: force beyond its range",
}
ATTITUDE_WORDS = {
    "FLIPPED": "second antenna: heading refused, it is turned by 180 degrees",
    "WRONG_LENGTH": "second antenna: refused, the baseline has a wrong length",
    "REFUSED": "second antenna: angles refused, they contradict the solution",
}


class Words:
    """Looks ten times a second, from the background."""

    def __init__(
        self, navigation: Navigation, exchange: Exchange, news: FrontEndNews, output: Output
    ) -> None:
        self._navigation = navigation
        self._exchange = exchange
        self._news = news
        self._output = output
        self._samples = 0
        self._quiet_looks = -START_LOOKS
        self._front_end_looks = 0
        self._restarts = 0
        self._status = 0
        self._errors = sum(news.imu_errors)
        self._line_said_ns = -AGAIN_NS
        self._line_is_bad = False
        self._good_looks = 0
        self._source = 0
        self._lost = False
        self._counts: dict[str, int] = {}
        self._said_ns: dict[str, int] = {}
        self._compass_said_ns = 0
        self._imu_clock = ImuClock(exchange, output)
        self._pulse = PulseWatch(news, output)

    @property
    def imu_is_silent(self) -> bool:
        """Whether no samples come."""
        return self._quiet_looks >= SILENT_LOOKS

    def look(self) -> None:
        """Say what is new."""
        now_ns = self._news.clock.now_ns()
        self._look_at_front_end()
        self._look_at_imu()
        self._look_at_line(now_ns)
        self._look_at_attitude(now_ns)
        self._imu_clock.look()
        self._pulse.look()

    def _look_at_front_end(self) -> None:
        if self._exchange.restarts != self._restarts:
            self._restarts = self._exchange.restarts
            self._output.send_text("front end restarted: navigation begins anew")
        before = self._front_end_looks
        self._front_end_looks = before + 1 if self._news.is_silent else 0
        if self._front_end_looks == SILENT_LOOKS:
            self._output.send_text("front end silent")
        elif before >= SILENT_LOOKS and not self._front_end_looks:
            self._output.send_text("front end is back")

    def _look_at_imu(self) -> None:
        samples, before = self._exchange.samples, self._quiet_looks
        self._quiet_looks = before + 1 if samples == self._samples else 0
        self._samples = samples
        if self._quiet_looks == SILENT_LOOKS:
            self._output.send_text("IMU silent")
        elif before >= SILENT_LOOKS and not self._quiet_looks:
            self._output.send_text("IMU answers again")
        status = self._exchange.status
        for bit, words in STATUS_WORDS.items():
            if status & ~self._status & bit:
                self._output.send_text(words)
        self._status = status

    def _look_at_line(self, now_ns: int) -> None:
        lost, bad, garbage, overruns, port = self._news.imu_errors
        errors = lost + bad + garbage + overruns + port
        grown, self._errors = errors > self._errors, errors
        self._good_looks = 0 if grown else self._good_looks + 1
        if grown and now_ns - self._line_said_ns >= AGAIN_NS:
            self._line_said_ns = now_ns
            self._line_is_bad = True
            counts = f"{lost} samples lost, {bad} bad frames, {garbage} bytes of garbage, {port} port errors"
            self._output.send_text(f"IMU line disturbed: {counts} so far")
        if self._line_is_bad and self._good_looks >= GOOD_LOOKS:
            self._line_is_bad = False
            self._output.send_text("IMU line is good again")

    def _look_at_attitude(self, now_ns: int) -> None:
        floats, integers = self._navigation.attitude_report()
        source = integers[report.YAW_SOURCE]
        if source != self._source:
            self._source = source
            self._output.send_text(f"heading from: {YAW_SOURCES[source]}")
        for name, words in ATTITUDE_WORDS.items():
            count = integers[getattr(report, name)]
            grown = count > self._counts.get(name, 0)
            self._counts[name] = count
            if grown and now_ns - self._said_ns.get(name, -AGAIN_NS) >= AGAIN_NS:
                self._said_ns[name] = now_ns
                self._output.send_text(words)
        lost = bool(self._output.flags >> fl.ATTITUDE_LOST & 1) and self._output.mode >= fl.NAVIGATING
        if lost != self._lost:
            self._lost = lost
            self._output.send_text("second antenna tells no heading" if lost else "second antenna is back")
        gathered = floats[report.COMPASS_TIME]
        gathering = self._output.mode == fl.WAITING_FOR_HEADING and gathered > 0.0
        if gathering and now_ns - self._compass_said_ns >= COMPASS_EVERY_NS:
            self._compass_said_ns = now_ns
            heading = floats[report.COMPASS_HEADING] * DEGREES % 360.0
            sigma = floats[report.COMPASS_SIGMA] * DEGREES
            self._output.send_text(
                f"gyro-compass: {heading:.2f} deg, 1 sigma {sigma:.2f} deg after {gathered:.0f} s"
            )
