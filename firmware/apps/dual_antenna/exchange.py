"""The DSP's end of the memory: samples and epochs for the tasks.

navigation   (mailbox)  what has come, and a strapdown step for each sample
filter       (task)     a Kalman update for each epoch
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from firmware.apps.dual_antenna import memory_map as at
from firmware.apps.dual_antenna.navigation import Navigation
from firmware.apps.dual_antenna.settings import Settings
from firmware.drivers import gnss_epoch as gnss
from firmware.drivers import serial_imu_frames as fr
from hal.board_io import BoardIo


class Exchange:
    """Takes what the front end posts."""

    def __init__(self, io: BoardIo, settings: Settings, navigation: Navigation) -> None:
        self.updated: Callable[[], None] = _nothing
        """Called in the filter task after each update."""
        self.samples = 0
        self.epochs = 0
        self.restarts = 0
        """Of the front end while this program runs."""
        self.latest: list[int] = gnss.new_epoch().tolist()
        """The epoch that the filter took last."""
        self._memory = io.memories["exchange"]
        self._interrupts = io.interrupts
        self._cpu = io.cpu
        self._navigation = navigation
        self._f, self._i = navigation.f, navigation.i
        self._step = navigation.kernels.sample_step
        self._step_cost = io.cpu.cost(f"navigation_{settings.precision}")
        self._update_cost = io.cpu.cost(f"filter_{settings.precision}")
        self._sample_bytes = bytearray(at.SAMPLE_WORDS * at.WORD)
        self._sample: NDArray[np.int64] = np.frombuffer(self._sample_bytes, np.int64)
        self._epoch = gnss.new_epoch()
        self._word = 0
        """The mailbox as it was read last."""
        self._posted = self._taken = 0
        """Samples, modulo 2¹⁶."""
        self._epochs_posted = 0
        self._steps_per_output = settings.steps_per_output
        self._steps = 0
        self._filter_line = io.interrupts.attach("filter", self._on_epochs)

    @property
    def status(self) -> int:
        """Of the latest sample."""
        return int(self._sample[fr.STATUS])

    @property
    def counted(self) -> tuple[int, int]:
        """Counter and time of the latest sample."""
        return int(self._sample[fr.COUNTER]), int(self._sample[fr.END_NS])

    def begin(self, send: Callable[[], None]) -> None:
        """Take what comes from now on; `send` is the output task."""
        self._output_line = self._interrupts.attach("output", send)
        line = self._interrupts.attach("navigation", self._on_ring)
        self._word = word = self._memory.rung()
        self._posted = self._taken = word & at.COUNT_MASK
        self._epochs_posted = word >> at.EPOCH_SHIFT & at.BYTE
        self._memory.interrupt_on_ring(line)

    def _on_ring(self) -> None:
        word = self._memory.rung()
        if (word ^ self._word) >> at.EPOCH_SHIFT:
            self._take_news(word)
        self._word = word
        self._posted = word & at.COUNT_MASK
        while self._taken != self._posted:
            self._take_sample()

    def _take_news(self, word: int) -> None:
        """An epoch has come, or the front end has begun anew: then it counts from zero, and so does its
        clock, and navigation has to begin anew, too."""
        if (word ^ self._word) >> at.START_SHIFT:
            self._taken = self._epochs_posted = 0
            if self._word >> at.START_SHIFT:
                self._navigation.begin_anew()
                self.restarts += 1
        epochs = word >> at.EPOCH_SHIFT & at.BYTE
        if epochs != self._epochs_posted:
            self._epochs_posted = epochs
            self._filter_line.pend()

    def _take_sample(self) -> None:
        waiting = (self._posted - self._taken) & at.COUNT_MASK
        if waiting > at.SAMPLES:
            self._navigation.samples_missed += waiting - at.SAMPLES
            self._taken = (self._posted - at.SAMPLES) & at.COUNT_MASK
        place = self._taken % at.SAMPLES * at.SAMPLE_WORDS
        self._sample_bytes[:] = self._memory.read(place, at.SAMPLE_WORDS)
        self._taken = (self._taken + 1) & at.COUNT_MASK
        step = self._step
        step(self._f, self._i, self._sample)
        self._cpu.spend(self._step_cost)
        self.samples += 1
        self._steps = steps = self._steps + 1
        if steps == self._steps_per_output:
            self._steps = 0
            self._output_line.pend()

    def _on_epochs(self) -> None:
        place = (self._epochs_posted - 1) % at.EPOCHS * at.EPOCH_WORDS + at.EPOCHS_AT
        self._epoch[:] = np.frombuffer(self._memory.read(place, at.EPOCH_WORDS), np.int64)
        self.epochs += 1
        self._navigation.take_epoch(self._epoch)
        self.latest = self._epoch.tolist()
        self._cpu.spend(self._update_cost)
        self.updated()


def _nothing() -> None:
    pass
