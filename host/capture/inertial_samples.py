"""What an inertial sensor measured, out of its recorded bus traffic: by the part's fact sheet alone.

BMI160 (fact sheet section 1): output registers 0x0C to 0x17 (gyroscope, then accelerometer, 16 bits each,
low byte first), sensor time 0x18 to 0x1A in ticks of 39.0625 µs; ranges in 0x41 and 0x43, rate codes in 0x40
and 0x42 (100 / 2^(8 − code) Hz); samples fall on multiples of their period on the sensor time. So a read
tells what was measured and how long before. Ranges and rates are followed through writes, reads and resets.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hal.emulated.i2c import I2cTransfer
from host.capture.blocks import SPI_HEAD, SpiTransaction
from host.record.tables import Table

STANDARD_GRAVITY = 9.80665
TICK_NS = 39_062.5

ACC_CONF, ACC_RANGE, GYR_CONF, GYR_RANGE, COMMAND = 0x40, 0x41, 0x42, 0x43, 0x7E
DEFAULTS = {ACC_CONF: 0x28, ACC_RANGE: 0x03, GYR_CONF: 0x28, GYR_RANGE: 0x00}
SOFT_RESET = 0xB6
GYRO, SENSOR_TIME, TEMPERATURE = 0x0C, 0x18, 0x20
LSB_PER_G = {0x3: 16384.0, 0x5: 8192.0, 0x8: 4096.0, 0xC: 2048.0}
LSB_PER_DPS = {0: 16.4, 1: 32.8, 2: 65.6, 3: 131.2, 4: 262.4}
NO_SAMPLE = -32768
AXES = struct.Struct("<6h")
BURST_SENT = b"\x10\0\0\0" + bytes((0x80 | GYRO,)) + bytes(15)
"""In a record, the length and MOSI of the common read: address, six axes, sensor time."""
IMU = Table(
    ("t_s", "rate_x_dps", "rate_y_dps", "rate_z_dps", "force_x_mps2", "force_y_mps2", "force_z_mps2"),
    (6, 4, 4, 4, 4, 4, 4),
)
"""Samples for people, in the chip's own axes."""


@dataclass(frozen=True, slots=True)
class InertialSamples:
    """Samples in the chip's own axes, in rising time."""

    times_ns: NDArray[np.int64]
    force: NDArray[np.float64]
    """(n, 3) m/s²."""
    rate: NDArray[np.float64]
    """(n, 3) rad/s."""
    temperature_times_ns: NDArray[np.int64]
    temperature: NDArray[np.float64]
    """°C; may be empty."""
    field: NDArray[np.float64] | None = None
    """(n, 3) T, of a sensor with magnetometers."""
    pressure: NDArray[np.float64] | None = None
    """(n,) Pa, of one with a barometer."""


class Bmi160Traffic:
    """Follows the registers of one BMI160 through its transactions."""

    def __init__(self) -> None:
        self._registers = dict(DEFAULTS)
        self._period_ticks = _period_ticks(self._registers)
        self._rows: list[tuple[int, float, float, float, float, float, float]] = []
        self._temperatures: list[tuple[int, float]] = []
        self._last_ns = -1

    def add(self, transactions: Iterable[SpiTransaction]) -> None:
        """Further transactions, in their order."""
        for one in transactions:
            address = one.mosi[0] & 0x7F
            if one.mosi[0] & 0x80:
                self._read(address, one.miso[1:], one.start_ns)
            elif len(one.mosi) == 2:
                self._write(address, one.mosi[1])

    def glimpse(self, block: bytes | bytearray, sent: Iterable[bytes]) -> tuple[float, ...] | None:
        """The last sample in a block of records (`host.capture.blocks`) as a row of IMU. `sent`: MOSI of the
        two-byte transactions in it. Made to cost little: nothing else of the block is looked at.
        """
        for address, value in sent:
            if not address & 0x80:
                self._write(address, value)
        found = block.rfind(BURST_SENT)
        if found < 0:
            return None
        (start_ns, _, n), miso = SPI_HEAD.unpack_from(block, found - 12), found + len(BURST_SENT)
        self._read(GYRO, bytes(block[miso + 1 : miso + n]), start_ns)
        if not self._rows:
            return None
        t_ns, *values = self._rows.pop()
        return t_ns / 1e9, *map(math.degrees, values[:3]), *values[3:]

    def samples(self) -> InertialSamples:
        """All samples so far."""
        table = np.array(self._rows, dtype=np.float64).reshape(-1, 7)
        temperatures = np.array(self._temperatures, dtype=np.float64).reshape(-1, 2)
        return InertialSamples(
            table[:, 0].astype(np.int64),
            table[:, 4:7],
            table[:, 1:4],
            temperatures[:, 0].astype(np.int64),
            temperatures[:, 1],
        )

    def _write(self, address: int, value: int) -> None:
        if address == COMMAND and value == SOFT_RESET:
            self._registers = dict(DEFAULTS)
        elif address in self._registers:
            self._registers[address] = value
        self._period_ticks = _period_ticks(self._registers)

    def _read(self, address: int, data: bytes, time_ns: int) -> None:
        if len(set(data)) == 1 and data[0] in (0x00, 0xFF) and len(data) > 1:
            return  # nobody answered
        if address == GYRO and len(data) >= AXES.size:
            self._sample(data, time_ns)
        elif address == TEMPERATURE and len(data) == 2:
            (count,) = struct.unpack("<h", data)
            if count != NO_SAMPLE:
                self._temperatures.append((time_ns, 23.0 + count / 512.0))

    def _sample(self, data: bytes, time_ns: int) -> None:
        counts = AXES.unpack_from(data)
        acc_scale = LSB_PER_G.get(self._registers[ACC_RANGE] & 0x0F)
        gyr_scale = LSB_PER_DPS.get(self._registers[GYR_RANGE] & 0x07)
        if acc_scale is None or gyr_scale is None or NO_SAMPLE in counts:
            return
        sampled_ns = time_ns - self._age_ns(data)
        if sampled_ns <= self._last_ns + self._period_ns() // 2:
            return  # the same sample once more
        self._last_ns = sampled_ns
        to_rate, to_force = math.radians(1.0 / gyr_scale), STANDARD_GRAVITY / acc_scale
        gx, gy, gz, ax, ay, az = counts
        self._rows.append(
            (
                sampled_ns,
                gx * to_rate,
                gy * to_rate,
                gz * to_rate,
                ax * to_force,
                ay * to_force,
                az * to_force,
            )
        )

    def _period_ns(self) -> int:
        return round(self._period_ticks * TICK_NS)

    def _age_ns(self, data: bytes) -> int:
        """How long before the read the sample was taken; 0 for a read without the sensor time."""
        place = SENSOR_TIME - GYRO
        if len(data) < place + 3:
            return 0
        ticks = int.from_bytes(data[place : place + 3], "little")
        return round((ticks % self._period_ticks) * TICK_NS)


def _period_ticks(registers: Mapping[int, int]) -> int:
    """Of the faster of both sensors: 25,600 ticks a second, 100 / 2^(8 − code) samples."""
    code = max(registers[ACC_CONF] & 0x0F, registers[GYR_CONF] & 0x0F)
    return 1 << max(0, 16 - code)


def register_access(done: I2cTransfer, clock_hz: int) -> SpiTransaction | None:
    """A transaction on I²C as the same access on SPI, beginning when the registers are read; None: refused.

    The bytes read take 9 clocks each, and the stop condition one.
    """
    if done.refusal is not None or not done.written:
        return None
    register, values = done.written[0], done.written[1:]
    if not done.asked:
        return SpiTransaction("", done.start_ns, done.end_ns, done.written, bytes(1 + len(values)))
    begin_ns = done.end_ns - (9 * len(done.read) + 1) * 1_000_000_000 // clock_hz
    sent = bytes((register | 0x80,)) + bytes(len(done.read))
    return SpiTransaction("", begin_ns, done.end_ns, sent, b"\0" + done.read)
