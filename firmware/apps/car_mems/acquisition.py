"""Acquisition of the inertial sensor: by its data-ready interrupt, or by the processor's timer.

The interrupt handler reads one burst and makes the navigation task ready; nothing else happens there.
"""

from __future__ import annotations

from firmware.apps.car_mems.settings import Settings
from firmware.drivers.bmi160 import Bmi160, Bmi160Config, Outcome
from hal.board_io import BoardIo
from hal.interrupts import InterruptLine
from hal.machine_code import mypyc_attr
from hal.pins import Edge


@mypyc_attr(allow_interpreted_subclasses=True)
class Acquisition:
    """Owns the chip and the line that reads it."""

    def __init__(self, io: BoardIo, settings: Settings) -> None:
        self.by_timer = settings.acquisition == "timer"
        self.read_at_ns = 0
        """Board clock at the start of the last read."""
        self.reads = 0
        self.outcome = Outcome.ABSENT
        self.sample_task: InterruptLine | None = None
        """Made ready by the interrupt when `chip.raw` holds a new sample."""
        self.starts = 0
        config = Bmi160Config(settings.imu_rate_hz, settings.imu_bandwidth, not self.by_timer)
        self.chip = Bmi160(io.spi["imu"], io.cpu, config)
        self._io = io
        self._cpu = io.cpu
        self._cost = io.cpu.cost("imu_interrupt")
        self._clock = io.clock
        self._line: InterruptLine | None = None
        self._rate_hz = settings.imu_rate_hz

    def begin(self) -> None:
        """Set the chip up and let it (or the timer) interrupt."""
        self.start_chip()
        if self.by_timer:
            self._line = self._io.interrupts.attach("imu_timer", self._on_interrupt)
            self._io.timers["imu_timer"].start(self._rate_hz, self._line)
        else:
            self._line = self._io.interrupts.attach("imu_ready", self._on_interrupt)
            self._io.inputs["imu_int1"].interrupt_on(Edge.RISING, self._line)

    def start_chip(self) -> Outcome:
        """One attempt to bring the chip up, without interrupts meanwhile."""
        if self._line is not None:
            self._line.disable()
        self.outcome = self.chip.start()
        self.starts += 1
        if self._line is not None:
            self._line.enable()
        return self.outcome

    def _on_interrupt(self) -> None:
        self.read_at_ns = self._clock.now_ns()
        self.chip.read()
        self.reads += 1
        self._cpu.spend(self._cost)
        task = self.sample_task
        if task is not None:
            task.pend()
