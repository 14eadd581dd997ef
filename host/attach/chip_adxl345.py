"""The ADXL345 on the desk. Its FIFO keeps what comes between two polls, so that no sample is missed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from firmware.drivers.adxl345 import DEVICE_ID, FIFO_ENTRIES, Adxl345, Adxl345Config, Outcome
from firmware.drivers.adxl345_ports import RegisterPort
from firmware.drivers.adxl345_sample import FORCE_SIZE, SAMPLE_LENGTH, convert, scale
from hal.cpu import Cpu
from host.attach.chip_on_desk import Found, Poll, Quantity

SAMPLES_PER_POLL = 8
POLLS_PER_S = (2.0, 50.0)
IDLE_ROW = b"\xff" * 6


class Adxl345OnDesk:
    """Implements `host.attach.chip_on_desk.ChipOnDesk`."""

    name = "adxl345"
    quantities = tuple(Quantity(f"force {axis}", "m/s²") for axis in "xyz")

    def __init__(self, port: RegisterPort, cpu: Cpu, rate_hz: float) -> None:
        self._chip = Adxl345(port, cpu, Adxl345Config(rate_hz=rate_hz, fifo="stream"))
        self._unit = scale()
        self._convert(np.zeros(SAMPLE_LENGTH, np.uint8))  # so that it is compiled before time counts
        self.polls_per_s = float(np.clip(rate_hz / SAMPLES_PER_POLL, *POLLS_PER_S))

    def start(self) -> Found:
        """Identify, set up and read back."""
        return self._found(self._chip.start())

    def check(self) -> Found:
        """Device id and settings."""
        return self._found(self._chip.check())

    def poll(self) -> Poll:
        """What waits in the FIFO; a full one has lost at least one sample."""
        chip = self._chip
        count = chip.read_fifo()
        rows = chip.fifo[:count]
        if count == FIFO_ENTRIES and all(row[1:].tobytes() == IDLE_ROW for row in rows):
            return Poll(alive=False)
        return Poll([self._convert(row) for row in rows], int(count == FIFO_ENTRIES))

    def temperature(self) -> float | None:
        """The part has no thermometer."""
        return None

    def clock_s(self) -> float | None:
        """The part has no clock that can be read."""
        return None

    def _convert(self, raw: NDArray[np.uint8]) -> NDArray[np.float32]:
        sample = np.empty(FORCE_SIZE, np.float32)
        convert(raw, self._unit, sample)
        return sample

    def _found(self, outcome: Outcome) -> Found:
        read = f"0x{self._chip.detail:02X}"
        if outcome is Outcome.OK:
            return Found(True, f"device id 0x{DEVICE_ID:02X}")
        if outcome in (Outcome.ABSENT, Outcome.WRONG_CHIP):
            told = f"{outcome.value}: device id reads {read}, an ADXL345 has 0x{DEVICE_ID:02X}"
            return Found(False, told, outcome is Outcome.ABSENT)
        return Found(False, f"{outcome.value}: {read} was read")
