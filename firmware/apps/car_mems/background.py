"""The background loop: configuration, sensor health, log, LED, watchdog. It runs when nothing else does."""

from __future__ import annotations

from typing import Final

from firmware.apps.car_mems.acquisition import Acquisition
from firmware.apps.car_mems.clock_watch import ClockWatch
from firmware.apps.car_mems.gnss_port import GnssPort
from firmware.apps.car_mems.navigation import Navigation
from firmware.apps.gnss_ins.announcements import Announcer
from firmware.apps.gnss_ins.output import Output
from firmware.drivers.bmi160 import Outcome
from hal.board_io import BoardIo
from hal.machine_code import mypyc_attr

RATE_HZ: Final = 10
WATCHDOG_NS: Final = 2_000_000_000
SILENT_TICKS: Final = 3
"""Ticks without a sample after which the sensor is called silent."""
START_PAUSE_TICKS: Final = 5
"""Between two attempts to bring the sensor up."""


@mypyc_attr(allow_interpreted_subclasses=True)
class Background:
    """What `main` does after set-up, for ever."""

    def __init__(
        self,
        io: BoardIo,
        navigation: Navigation,
        gnss: GnssPort,
        acquisition: Acquisition,
        output: Output,
        announcer: Announcer,
    ) -> None:
        self._io = io
        self._navigation = navigation
        self._gnss = gnss
        self._acquisition = acquisition
        self._output = output
        self._announcer = announcer
        self._clocks = ClockWatch(navigation, gnss, output)
        self._health_cost = io.cpu.cost("health_check")
        self._tick_line = io.interrupts.attach("background_tick", self._on_tick)
        self._led = io.outputs["led"]
        self._led_level = False
        """Blinking while not navigating, steady while navigating."""
        self._ticks = 0
        self._reads_seen = 0
        self._silent_ticks = 0
        self._start_after = 0
        self._start_said = Outcome.OK
        self._shown_ns = 0

    def run(self) -> None:
        """The loop; returns only when the processor is reset or switched off."""
        io = self._io
        wait = io.cpu.wait_for_interrupt
        io.watchdog.start(WATCHDOG_NS)
        io.timers["background"].start(RATE_HZ, self._tick_line)
        done = 0
        while True:
            while self._ticks == done:
                wait()
            done = self._ticks
            io.watchdog.kick()
            self._gnss.service()
            self._watch_imu()
            self._output.write_log()
            self._announcer.look()
            if done % RATE_HZ == 0:
                self._every_second()

    def _on_tick(self) -> None:
        self._ticks += 1

    def _watch_imu(self) -> None:
        """A sensor that has gone silent is started again, one attempt every half second."""
        acquisition = self._acquisition
        if acquisition.reads != self._reads_seen:
            self._reads_seen = acquisition.reads
            self._silent_ticks = 0
            return
        self._silent_ticks += 1
        if self._silent_ticks >= SILENT_TICKS:
            self._show_state()
            if self._ticks >= self._start_after:
                self._restart_imu("silent")

    def _show_state(self) -> None:
        """Without samples nothing drives the output: each epoch that moved the state is shown from here."""
        state_ns = self._navigation.state_ns
        if state_ns > self._shown_ns:
            self._shown_ns = state_ns
            self._output.send()

    def _every_second(self) -> None:
        self._io.cpu.spend(self._health_cost)
        self._led.set(self._navigation.is_navigating or not self._led_level)
        self._led_level = not self._led_level
        if self._silent_ticks == 0:
            found = self._acquisition.chip.check()
            if found is not Outcome.OK:
                found = self._acquisition.chip.check()  # a bit flipped on the wire is no reason to restart
            if found is not Outcome.OK:
                self._restart_imu(found.value)
            else:
                self._imu_is_well()
        self._output.send_slow()
        self._announcer.look_at_line()
        self._clocks.look()

    def _imu_is_well(self) -> None:
        if self._start_said is not Outcome.OK:
            self._start_said = Outcome.OK
            self._output.send_text("IMU answers again")
        celsius = self._acquisition.chip.temperature()
        if celsius is not None:
            self._navigation.take_temperature(celsius)

    def _restart_imu(self, why: str) -> None:
        self._start_after = self._ticks + START_PAUSE_TICKS
        found = self._acquisition.start_chip()
        self._navigation.restart_sample_clock()
        detail = self._acquisition.chip.detail
        if found is Outcome.OK or found is not self._start_said:
            self._output.send_text(f"IMU {why}: restarted, {found.value} (0x{detail:02X})")
        self._start_said = found
