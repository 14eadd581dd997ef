"""The background loop: the sensor's health, announcements, watchdog. It runs when nothing else does."""

from __future__ import annotations

import math
from collections.abc import Callable

from firmware.apps.uav_ahrs.announcements import Announcer
from firmware.apps.uav_ahrs.attitude import Attitude
from firmware.apps.uav_ahrs.diagnosis import flags_in_words
from firmware.apps.uav_ahrs.output import Output
from firmware.apps.uav_ahrs.sensor import Sensor
from firmware.apps.uav_ahrs.settings import Settings
from firmware.drivers.adis16407 import Outcome
from hal.board_io import BoardIo

RATE_HZ = 10
WATCHDOG_NS = 2_000_000_000
MORE_PATIENCE_S = 8
START_PAUSE_TICKS = 5
"""Between two attempts to bring the sensor up."""


class Background:
    """What `main` does after set-up, for ever."""

    def __init__(
        self,
        io: BoardIo,
        attitude: Attitude,
        sensor: Sensor,
        output: Output,
        announcer: Announcer,
        settings: Settings,
    ) -> None:
        self._attitude = attitude
        self._patience_s = math.ceil(settings.alignment_s) + MORE_PATIENCE_S
        """Seconds of alignment after which nobody waits for rest any longer."""
        self._io = io
        self._sensor = sensor
        self._output = output
        self._announcer = announcer
        self._health_cost = io.cpu.cost("health_check")
        self._tick_line = io.interrupts.attach("background_tick", self._on_tick)
        self._ticks = 0
        self._start_after = 0
        self._bus_work: list[Callable[[], None]] = []
        """What waits for a pause between bursts: one that came between would take an answer away."""
        self._said = Outcome.OK
        self._said_detail = 0

    def run(self) -> None:
        """The loop; returns only when the processor is reset or switched off."""
        io, sensor = self._io, self._sensor
        wait = io.cpu.wait_for_interrupt
        io.watchdog.start(WATCHDOG_NS)
        io.timers["background"].start(RATE_HZ, self._tick_line)
        done = 0
        bus_work = self._bus_work
        while True:
            while self._ticks == done:
                wait()
                if bus_work and sensor.bus_is_quiet():
                    bus_work.pop(0)()
            done = self._ticks
            io.watchdog.kick()
            if sensor.is_silent and done >= self._start_after:
                self._set_up()
            self._announcer.look()
            if not bus_work and sensor.look_is_due():
                bus_work.append(self._look)
            if done % RATE_HZ == 0:
                self._every_second()

    def _on_tick(self) -> None:
        self._ticks += 1

    def _look(self) -> None:
        """When do samples come? Again after the next burst while that is not known well."""
        sensor = self._sensor
        if sensor.look_is_due():
            sensor.look_for_sample()
        if not sensor.phase.is_settled and sensor.answers:
            self._bus_work.append(self._look)

    def _every_second(self) -> None:
        self._io.cpu.spend(self._health_cost)
        if self._sensor.answers and not self._sensor.failed_reads and self._check not in self._bus_work:
            self._bus_work.append(self._check)
        self._look_at_alignment()
        self._announcer.look_at_bus()
        self._announcer.look_at_clock(self._sensor)
        self._output.send_slow()

    def _look_at_alignment(self) -> None:
        if not self._attitude.is_aligning or not self._sensor.answers:
            return
        self._patience_s -= 1
        if self._patience_s == 0:
            self._attitude.align_in_motion()
            self._output.send_text("alignment: no rest to be had, aligning in motion")

    def _check(self) -> None:
        found = self._sensor.check()
        if found is Outcome.NOT_CONFIGURED:
            self._set_up()
        else:
            self._tell(found)

    def _set_up(self) -> None:
        self._start_after = self._ticks + START_PAUSE_TICKS
        self._io.watchdog.kick()
        found = self._sensor.set_up()
        if found is Outcome.OK:
            self._output.send_text("sensor: set up anew")
        self._tell(found)

    def tell_start(self) -> None:
        """What was found at power-on."""
        found = self._sensor.outcome
        detail = self._sensor.chip.detail
        if found is Outcome.OK:
            self._output.send_text(
                "sensor: ADIS16407, self-test passed" if detail == 0 else "sensor: ADIS16407"
            )
        self._tell(found)

    def _tell(self, found: Outcome) -> None:
        detail = self._sensor.chip.detail if found is not Outcome.OK else 0
        if (found, detail) == (self._said, self._said_detail):
            return
        self._said, self._said_detail = found, detail
        if found is Outcome.OK:
            self._output.send_text("sensor: well again")
        else:
            words = flags_in_words(detail) if found in DIAGNOSED else f"0x{detail:04X}"
            self._output.send_text(f"sensor: {found.value}: {words}")


DIAGNOSED = (Outcome.ERROR_FLAG, Outcome.ALARM, Outcome.SELF_TEST_FAILED)
