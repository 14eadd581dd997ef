"""Clocks of other chips that went wrong: the sensor's sample clock, the receiver's time pulse.

Neither stops navigation: the loop of `sample_clock` follows the sensor, and epochs without a pulse are
dated by their bursts. But a clock that far off is about to fail, and people at the host are told.
"""

from __future__ import annotations

from typing import Final

from firmware.apps.car_mems.gnss_port import GnssPort
from firmware.apps.car_mems.navigation import Navigation
from firmware.apps.car_mems.sample_clock import NOMINAL_TICK, TICK
from firmware.apps.car_mems.steps import CLOCK_AT
from firmware.apps.gnss_ins.output import Output
from firmware.apps.gnss_ins.pulse_watch import PulseWatch
from hal.machine_code import mypyc_attr

MILLION: Final = 1_000_000
BAD_PPM: Final = 10_000
"""1 %: twice what the sensors of this kind are off by."""
GOOD_PPM: Final = 8_000
LOOKS: Final = 3
"""In a row that agree: the loop has settled."""


@mypyc_attr(allow_interpreted_subclasses=True)
class ClockWatch:
    """Looked at once a second, from the background."""

    def __init__(self, navigation: Navigation, receiver: GnssPort, output: Output) -> None:
        self._memory = navigation.i
        self._output = output
        self._sensor_is_bad = False
        self._sensor_looks = 0
        self._pulse = PulseWatch(receiver, output)

    def look(self) -> None:
        """Say what has changed."""
        self._look_at_sensor()
        self._pulse.look()

    def _look_at_sensor(self) -> None:
        ppm = round((int(NOMINAL_TICK) / int(self._memory[CLOCK_AT + TICK]) - 1.0) * MILLION)
        bad = abs(ppm) > (GOOD_PPM if self._sensor_is_bad else BAD_PPM)
        self._sensor_looks = 0 if bad == self._sensor_is_bad else self._sensor_looks + 1
        if self._sensor_looks == LOOKS:
            self._sensor_is_bad, self._sensor_looks = bad, 0
            self._output.send_text(f"IMU clock {ppm:+d} ppm off" if bad else "IMU clock is good again")
