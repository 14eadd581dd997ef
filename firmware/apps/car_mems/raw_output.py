"""Tells the host what navigation takes in (profile key `raw_output`) as frames of `firmware.link.raw_frames`.

A frame must stand on the link in the order in which navigation took its input, and inputs come from tasks
of two priorities. So each is told in one go: first the room on the port is looked at, which lets time pass,
then the input goes into the kernel and its frame into the queue, without a pause in which another task
could come between (on the processor: with interrupts held off).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware.apps.car_mems.navigation import Navigation, NavigationKernels
from firmware.apps.car_mems.settings import Settings
from firmware.drivers.gnss_epoch import ONE_ANTENNA_SIZE
from firmware.link import raw_frames as raw
from firmware.link.crc import crc16
from firmware.nav.config import NavConfig
from firmware.numerics.dialect import entry_point
from hal.board_io import BoardIo

SAMPLE_RATE_HZ = 100
OTHER_BYTES_A_SECOND = 1_500
"""Once-a-second frames, sentences, epochs at 10 Hz."""
SOLUTION_FRAME_BYTES = 116
LARGEST_SHARE = 0.8
"""Of the port's capacity, so that its queue empties between bursts."""

Tell = Callable[[int, bytes], None]


def lowest_baud(settings: Settings) -> int:
    """Bits a second that the host port needs for raw output."""
    solutions = settings.output_rate_hz * SOLUTION_FRAME_BYTES
    samples = SAMPLE_RATE_HZ * raw.IMU_FRAME_BYTES
    slices = SAMPLE_RATE_HZ // raw.SAMPLES_A_SLICE * raw.SLICE_FRAME_BYTES
    return round(10 * (solutions + samples + slices + OTHER_BYTES_A_SECOND) / LARGEST_SHARE)


def check_baud(settings: Settings, baud: int) -> None:
    """Raises ValueError for a host port too slow for raw output."""
    needed = lowest_baud(settings)
    if baud < needed:
        raise ValueError(
            f"raw_output = true needs {needed} baud on the host port, which has {baud}; for example"
            " board.uarts.host.baud=230400, or a lower output_rate_hz"
        )


class ToldNavigation(Navigation):
    """Navigation that tells every input. `tell_room` asks for room on the port, `tell` sends or drops."""

    def __init__(
        self, kernels: NavigationKernels, config: NavConfig, io: BoardIo, settings: Settings
    ) -> None:
        super().__init__(kernels, config)
        self._io = io
        self._settings = settings
        self._number = 0
        self._slices: list[bytes] = []
        self._samples = 0
        self._latest: Callable[[], NDArray[np.int64]] = _no_epoch
        self._look: Callable[[], None] = _nothing
        self._tell: Tell = _to_nobody
        self._cost = io.cpu.cost("raw_frame")
        self._slice_cost = io.cpu.cost("raw_slice")

    def begin(self, look: Callable[[], None], tell: Tell, latest: Callable[[], NDArray[np.int64]]) -> None:
        """Say that navigation begins anew, and with what memory.

        `look()` asks the port for its room, `tell(kind, payload)` sends by what it said; `latest()`: the
        epoch that the filter took last.
        """
        self._look, self._tell, self._latest = look, tell, latest
        settings = self._settings
        memory = np.frombuffer(bytearray(self.f.tobytes() + self.i.tobytes()), np.uint8)
        self._look()
        self._put(
            raw.RAW_START,
            raw.RAW_FORMAT,
            settings.strapdown != "mean",
            self.f.itemsize,
            settings.steps_per_output,
            len(self.f),
            len(self.i),
            entry_point(crc16)(memory, 0, len(memory)),
            self._io.clock.now_ns() // 1000,
        )

    def sample_step(self, mean: bool) -> Callable[..., int]:
        """The kernel call for a sample, and its frame."""
        step = super().sample_step(mean)
        spend = self._io.cpu.spend

        def told(f: NDArray[Any], i: NDArray[np.int64], burst: NDArray[np.uint8], read_at_ns: int) -> int:
            self._look()
            made = step(f, i, burst, read_at_ns)
            self._put(raw.RAW_IMU, read_at_ns, burst[1:].tobytes())
            spend(self._cost)
            self._samples += 1
            if self._samples == raw.SAMPLES_A_SLICE:
                self._samples = 0
                self._tell_slice()
            return made

        return told

    def take_epoch(self, epoch: NDArray[np.int64], pulse: tuple[int, int]) -> None:
        """An epoch into the filter, and its frame."""
        self._look()
        record = epoch[:ONE_ANTENNA_SIZE].tolist()
        super().take_epoch(epoch, pulse)
        self._put(raw.RAW_EPOCH, *pulse, *record)
        self._io.cpu.spend(self._cost)

    def take_temperature(self, celsius: float) -> None:
        """A temperature, and its frame."""
        self._look()
        super().take_temperature(celsius)
        self._put(raw.RAW_TEMPERATURE, celsius)
        self._io.cpu.spend(self._cost)

    def restart_sample_clock(self) -> None:
        """The sensor begins anew, and its frame."""
        self._look()
        super().restart_sample_clock()
        self._put(raw.RAW_CLOCK)
        self._io.cpu.spend(self._cost)

    def _put(self, kind: int, *values: float | bytes) -> None:
        self._tell(kind, raw.INPUTS[kind].pack(self._number & 0xFFFF_FFFF, *values))
        self._number += 1

    def _tell_slice(self) -> None:
        """The next part of the copy of the memory, or of a new one."""
        self._look()
        if not self._slices:
            memory = self.f.tobytes() + self.i.tobytes() + self._latest().tobytes()
            self._slices = raw.slices_of(memory, self._number & 0xFFFF_FFFF)[::-1]
        self._tell(raw.RAW_STATE, self._slices.pop())
        self._io.cpu.spend(self._slice_cost)


def _no_epoch() -> NDArray[np.int64]:
    return np.zeros(0, np.int64)


def _nothing() -> None:
    pass


def _to_nobody(_kind: int, _payload: bytes) -> None:
    pass
