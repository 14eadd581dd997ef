"""What an ADIS16407 measured, out of its recorded words (fact sheet sections 2 to 5).

A burst is the word 0x4200 and 14 more in one chip-select period; words of gyro, accelerometer and
magnetometer have 14 bits in two's complement below ND and EA. SENS_AVG (0x3C) holds the gyros' range and the
filter: two stages of 2^N samples, which together show the motion 2^N − 1 samples ago. Nothing tells how old a
sample is when it is read: half a sample period on the mean.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterable

import numpy as np

from host.capture.blocks import SPI_HEAD, SpiTransaction
from host.capture.inertial_samples import STANDARD_GRAVITY, InertialSamples

BURST = b"\x42" + bytes(29)
BURST_SENT = struct.pack("<I", len(BURST)) + BURST
"""In a record: length and MOSI."""
WORDS = struct.Struct(">15H")
PERIOD_NS = 1_000_000_000 * 10 / 8192
"""819.2 samples a second."""
SENS_AVG, GLOB_CMD, RESET = 0x3C, 0x42, 0x80
DEFAULT_AVERAGING = 0x0402
RANGES_DPS = {0b100: 300.0, 0b010: 150.0, 0b001: 75.0}
NEW_DATA, NOBODY = 0x8000, (0x0000, 0xFFFF)
LEAST_BARO = 125
"""10 mbar, the least that the part measures: words that have slipped show less or more."""
MOST_BARO = 15_000


class Adis16407Traffic:
    """Follows the settings of one ADIS16407 through its transactions."""

    def __init__(self) -> None:
        self._averaging = DEFAULT_AVERAGING
        self._rows: list[tuple[float, ...]] = []

    def add(self, transactions: Iterable[SpiTransaction]) -> None:
        """Further transactions, in their order."""
        for one in transactions:
            if one.mosi == BURST:
                self._burst(one.miso, one.start_ns)
            elif len(one.mosi) == 2:
                self._write(one.mosi[0], one.mosi[1])

    def glimpse(self, block: bytes | bytearray, sent: Iterable[bytes]) -> tuple[float, ...] | None:
        """The last sample in a block of records as a row of `inertial_samples.IMU`; see there."""
        for address, value in sent:
            self._write(address, value)
        found = block.rfind(BURST_SENT)
        if found < 0:
            return None
        start_ns, _, n = SPI_HEAD.unpack_from(block, found + 4 - SPI_HEAD.size)
        miso = found + len(BURST_SENT)
        self._burst(bytes(block[miso : miso + n]), start_ns)
        if not self._rows:
            return None
        t_ns, *values = self._rows.pop()[:7]
        return t_ns / 1e9, *map(math.degrees, values[:3]), *values[3:]

    def samples(self) -> InertialSamples:
        """All samples so far."""
        table = np.array(self._rows, dtype=np.float64).reshape(-1, 12)
        times_ns = table[:, 0].astype(np.int64)
        return InertialSamples(
            times_ns, table[:, 4:7], table[:, 1:4], times_ns, table[:, 11], table[:, 7:10], table[:, 10]
        )

    def _write(self, address: int, value: int) -> None:
        if address == 0x80 | SENS_AVG:
            self._averaging = self._averaging & 0xFF00 | value
        elif address == 0x80 | SENS_AVG + 1:
            self._averaging = self._averaging & 0x00FF | value << 8
        elif address == 0x80 | GLOB_CMD and value & RESET:
            self._averaging = DEFAULT_AVERAGING

    def _burst(self, miso: bytes, time_ns: int) -> None:
        _, *words = WORDS.unpack(miso)
        baro = words[10] & 0x3FFF
        if all(word in NOBODY for word in words) or not LEAST_BARO <= baro <= MOST_BARO:
            return
        if not all(word & NEW_DATA for word in words[1:10]):
            return  # the same sample once more
        taps = 1 << (self._averaging & 7)
        shown_ns = time_ns - round((taps - 0.5) * PERIOD_NS)
        to_rate = math.radians(0.05) * RANGES_DPS.get(self._averaging >> 8 & 7, 300.0) / 300.0
        counts = [_signed(word, 14) for word in words[1:10]]
        self._rows.append(
            (
                float(shown_ns),
                *(to_rate * count for count in counts[0:3]),
                *(STANDARD_GRAVITY / 300.0 * count for count in counts[3:6]),
                *(0.5e-7 * count for count in counts[6:9]),
                0.03125 * (baro << 8 | words[11] & 0xFF),
                25.0 + 0.136 * _signed(words[12], 12),
            )
        )


def _signed(word: int, bits: int) -> int:
    half = 1 << (bits - 1)
    return ((word & (2 * half - 1)) ^ half) - half
