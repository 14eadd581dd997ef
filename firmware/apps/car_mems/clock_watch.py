"""Clocks of other chips that went wrong: the sensor's sample clock, the receiver's time pulse.

Neither stops navigation: the loop of `sample_clock` follows the sensor, and epochs without a pulse are
dated by their bursts. But a clock that far off is about to fail, and people at the host are told.
"""

from __future__ import annotations

from firmware.apps.car_mems.gnss_port import GnssPort
from firmware.apps.car_mems.navigation import Navigation
from firmware.apps.car_mems.sample_clock import NOMINAL_TICK, TICK
from firmware.apps.car_mems.steps import CLOCK_AT
from firmware.apps.gnss_ins.output import Output
from firmware.drivers import gnss_epoch as gnss

MILLION = 1_000_000
BAD_PPM = 10_000
"""1 %: twice what the sensors of this kind are off by."""
GOOD_PPM = 8_000
LOOKS = 3
"""In a row that agree: the loop has settled, and a pulse comes once a second only."""


class ClockWatch:
    """Looked at once a second, from the background."""

    def __init__(self, navigation: Navigation, receiver: GnssPort, output: Output) -> None:
        self._memory = navigation.i
        self._receiver = receiver
        self._output = output
        self._sensor_is_bad = False
        self._sensor_looks = 0
        self._pulse_is_lost = False
        self._pulse_looks = 0
        self._epochs = 0

    def look(self) -> None:
        """Say what has changed."""
        self._look_at_sensor()
        self._look_at_pulse()

    def _look_at_sensor(self) -> None:
        ppm = round((int(NOMINAL_TICK) / int(self._memory[CLOCK_AT + TICK]) - 1.0) * MILLION)
        bad = abs(ppm) > (GOOD_PPM if self._sensor_is_bad else BAD_PPM)
        self._sensor_looks = 0 if bad == self._sensor_is_bad else self._sensor_looks + 1
        if self._sensor_looks == LOOKS:
            self._sensor_is_bad, self._sensor_looks = bad, 0
            self._output.send_text(f"IMU clock {ppm:+d} ppm off" if bad else "IMU clock is good again")

    def _look_at_pulse(self) -> None:
        receiver = self._receiver
        if receiver.epochs == self._epochs:
            return
        self._epochs = receiver.epochs
        located = receiver.latest[gnss.FLAGS] & gnss.HAS_POSITION
        lost = bool(receiver.time.pulses and located and not receiver.pulse_dated)
        self._pulse_looks = 0 if lost == self._pulse_is_lost else self._pulse_looks + 1
        if self._pulse_looks == LOOKS:
            self._pulse_is_lost, self._pulse_looks = lost, 0
            self._output.send_text("time pulse lost" if lost else "time pulse is back")
