"""The inertial sensor on SPI-A: set up, read every 4 ms by a timer, looked after from the background.

    imu_timer (250 Hz) ─► burst read ─► sample ─► every second one: attitude task

A sensor that is being set up, or that nobody finds, is not read; the attitude computer then gets a burst
without answer, so that its time goes on.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from firmware.apps.uav_ahrs.attitude import Attitude
from firmware.apps.uav_ahrs.plausibility import FAILED_ROW
from firmware.apps.uav_ahrs.sample_phase import UNKNOWN, SamplePhase
from firmware.apps.uav_ahrs.settings import Settings
from firmware.apps.uav_ahrs.steps import READY
from firmware.drivers.adis16407 import PRODUCT_ID, Adis16407, Adis16407Config, Outcome
from firmware.drivers.adis16407_sample import BURST_LENGTH
from hal.board_io import BoardIo
from hal.interrupts import InterruptLine

READS_PER_S = 250
FILTER_STAGES_TAPS = 4
"""SENS_AVG as it is at power-on: two stages of four taps, which delay by three samples."""
NOMINAL_SAMPLE_NS = 1_220_703
DELAY_NS = (FILTER_STAGES_TAPS - 1) * NOMINAL_SAMPLE_NS
"""From the motion to the sample that shows it."""
LOOK_AGE_NS = 66_000
"""From the renewal of the outputs until `await_sample` returns, on the mean: two and a half words."""
QUIET_NS = 1_200_000
"""Later after a read there is not enough time for other words before the next one."""
BEFORE_NS = 150_000
SILENT_READS = 75
"""0.3 s without a sample: the sensor is set up anew. (A reset of its own takes 0.21 s.)"""


class Sensor:
    """Owns the chip, the timer and the burst."""

    def __init__(self, io: BoardIo, attitude: Attitude, settings: Settings) -> None:
        # As at power-on (the document sets nothing): ±300 °/s, 819.2 Hz; data ready on DIO1 is not wired.
        self.chip = Adis16407(io.spi["imu"], io.cpu, Adis16407Config())
        self.read_at_ns = 0
        """Board clock at the start of the last read."""
        self.reads = 0
        self.starts = 0
        self.outcome = Outcome.ABSENT
        self.diagnosis = 0
        """DIAG_STAT, all flags seen since they were last told."""
        self.product_id = 0
        self.phase = SamplePhase()
        self.ready: Callable[[], None] = _nobody
        """Called when three samples wait for an iteration."""
        self._io = io
        self._clock = io.clock
        self._cpu = io.cpu
        self._attitude = attitude
        self._take = attitude.take_burst
        self._burst = attitude.burst_memory(self.chip.raw)
        self._wants_self_test = settings.self_test
        self._no_burst = attitude.burst_memory(np.zeros(BURST_LENGTH, np.uint8))
        self._answers = False
        self._cost = io.cpu.cost(f"take_burst_{settings.arithmetic}")
        self._line: InterruptLine | None = None

    def begin(self) -> Outcome:
        """Set the chip up and let the timer interrupt."""
        self.set_up()
        if self.outcome is Outcome.OK and self._wants_self_test:
            self.outcome = self.chip.self_test()
            self.diagnosis |= self.chip.detail
        self._line = self._io.interrupts.attach("imu_timer", self._on_timer)
        self._io.timers["imu_timer"].start(READS_PER_S, self._line)
        return self.outcome

    def set_up(self) -> Outcome:
        """One attempt to bring the chip up; reads bring nothing meanwhile."""
        self._answers = False
        self.outcome = self.chip.start()
        self.starts += 1
        self._note(self.outcome)
        self._answers = self.outcome not in (Outcome.ABSENT, Outcome.WRONG_CHIP)
        self.phase.restart()
        return self.outcome

    def check(self) -> Outcome:
        """What the chip says of itself. Identity and settings are asked for twice when they are wrong, since
        a bit may have flipped; flags clear with the first answer."""
        found = self.chip.check()
        self._note(found)
        if found not in (Outcome.OK, Outcome.ERROR_FLAG, Outcome.ALARM):
            found = self.chip.check()
            self._note(found)
        return found

    @property
    def answers(self) -> bool:
        """Whether it is read."""
        return self._answers

    @property
    def failed_reads(self) -> int:
        """In a row."""
        return int(self._attitude.k[FAILED_ROW])

    @property
    def is_silent(self) -> bool:
        """Whether it is to be set up anew."""
        return not self._answers or self.failed_reads >= SILENT_READS

    def bus_is_quiet(self) -> bool:
        """Whether there is time for some words before the next burst."""
        return self._clock.now_ns() - self.read_at_ns < QUIET_NS

    def look_is_due(self) -> bool:
        """Whether `look_for_sample` is to be called, when the bus is quiet."""
        return self._answers and self._clock.now_ns() >= self.phase.next_look_ns

    def look_for_sample(self) -> None:
        """When do the samples come? Where that is known well, looking begins shortly before."""
        phase = self.phase
        if phase.is_settled:
            ahead_ns = (phase.period >> 16) - phase.age_ns(self._clock.now_ns()) - BEFORE_NS
            if ahead_ns > 0:
                self._cpu.delay(ahead_ns)
        if self.chip.await_sample():
            self.phase.renewed(self._clock.now_ns() - LOOK_AGE_NS)

    def sample_age_us(self) -> int | None:
        """Of the sample read last; None: not known."""
        age_ns = self.phase.age_ns(self.read_at_ns)
        return None if age_ns == UNKNOWN else age_ns // 1000

    def valid_at_ns(self) -> int:
        """The board time that the last sample shows: of unknown age, so of mean age, and filtered."""
        return self.read_at_ns - NOMINAL_SAMPLE_NS // 2 - DELAY_NS

    def _note(self, found: Outcome) -> None:
        detail = self.chip.detail
        if found in (Outcome.ABSENT, Outcome.WRONG_CHIP):
            self.product_id = detail
            return
        self.product_id = PRODUCT_ID
        if found in (Outcome.ERROR_FLAG, Outcome.ALARM):
            self.diagnosis |= detail

    def _on_timer(self) -> None:
        self.read_at_ns = self._clock.now_ns()
        self.reads += 1
        take = self._take
        if self._answers:
            self.chip.read()
            found = take(*self._burst)
        else:
            found = take(*self._no_burst)
        self._cpu.spend(self._cost)
        if found & READY:
            self.ready()


def _nobody() -> None:
    pass
