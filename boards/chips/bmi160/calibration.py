"""Offset compensation, fast offset compensation (FOC) and self-test deflection (fact sheet sections 3 and 5).

Offsets are added to what was measured: accelerometer 1/256 g (3.9 mg) per LSB, 8 bits signed, in every
range; gyroscope 31.25/512 deg/s (0.061 deg/s) per LSB, 10 bits signed. FOC measures for FOC_NS and writes
the negated error, limited to what the registers hold.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import pi

import numpy as np
from numpy.typing import NDArray

from boards.chips.bmi160.register_map import ACC_RANGE, GYR_RANGE, OFFSET_0, OFFSET_6, SELF_TEST
from boards.chips.bmi160.sampler import Conversion
from boards.chips.bmi160.settings import STANDARD_GRAVITY, accel_counts_per_mps2, gyro_counts_per_radps

FOC_NS = 250_000_000
ACCEL_OFFSET_LSB_G = 1.0 / 256.0
GYRO_OFFSET_LSB_DEGREES = 31.25 / 512.0

SELF_TEST_DEFLECTION_G = 1.5
"""At high amplitude, either way: the difference of both signs is 3 g where the recipe wants more than 2 g."""

_TARGET_G = {1: 1.0, 2: -1.0, 3: 0.0}
"""FOC_CONF axis code -> what the axis should show."""


def _signed(value: int, bits: int) -> int:
    return value - (1 << bits) if value >> (bits - 1) else value


def accel_offsets_g(registers: Sequence[int]) -> tuple[float, float, float]:
    """What is added to the accelerometer, x, y, z; zero while acc_off_en is off."""
    if not registers[OFFSET_6] & 0x40:
        return 0.0, 0.0, 0.0
    x, y, z = (_signed(registers[OFFSET_0 + axis], 8) * ACCEL_OFFSET_LSB_G for axis in range(3))
    return x, y, z


def gyro_offsets_degrees(registers: Sequence[int]) -> tuple[float, float, float]:
    """What is added to the gyroscope in deg/s, x, y, z; zero while gyr_off_en is off."""
    high = registers[OFFSET_6]
    if not high & 0x80:
        return 0.0, 0.0, 0.0
    x, y, z = (
        _signed((high >> 2 * axis & 3) << 8 | registers[OFFSET_0 + 3 + axis], 10) * GYRO_OFFSET_LSB_DEGREES
        for axis in range(3)
    )
    return x, y, z


def self_test_deflection_g(registers: Sequence[int]) -> float:
    """Electrostatic deflection of all three axes: upwards with sign 0, so that 0x09 minus 0x0D > 0."""
    control = registers[SELF_TEST]
    if control & 0x03 != 0x01:
        return 0.0
    amplitude = SELF_TEST_DEFLECTION_G if control & 0x08 else SELF_TEST_DEFLECTION_G / 2
    return -amplitude if control & 0x04 else amplitude


def conversion(registers: Sequence[int]) -> Conversion:
    """How the sampler makes counts of physical values under the present registers."""
    accel = accel_counts_per_mps2(registers[ACC_RANGE])
    gyro = gyro_counts_per_radps(registers[GYR_RANGE])
    deflection = self_test_deflection_g(registers)
    added = [(offset + deflection) * STANDARD_GRAVITY * accel for offset in accel_offsets_g(registers)]
    turned = [offset * pi / 180.0 * gyro for offset in gyro_offsets_degrees(registers)]
    return Conversion(
        scale=np.array([accel] * 3 + [gyro] * 3),
        bias=np.array(added + turned),
    )


class OffsetMeasurement:
    """One FOC run: collects samples without offsets, then writes the registers."""

    def __init__(self, foc_conf: int, *, accel: bool, gyro: bool) -> None:
        """`accel`, `gyro`: which sensor is in normal mode and takes part."""
        codes = (foc_conf >> 4 & 3, foc_conf >> 2 & 3, foc_conf & 3)
        self.axes = {axis: _TARGET_G[code] for axis, code in enumerate(codes) if code and accel}
        self.gyro = bool(foc_conf & 0x40) and gyro
        self._sum: NDArray[np.float64] = np.zeros(7)
        self._count = 0

    @property
    def runs(self) -> bool:
        """Whether there is anything to measure."""
        return bool(self.axes) or self.gyro

    def complete(self, foc_conf: int) -> bool:
        """Whether everything that FOC_CONF asks for takes part."""
        return (self.gyro or not foc_conf & 0x40) and (bool(self.axes) or not foc_conf & 0x3F)

    def add(self, physical: NDArray[np.float64]) -> None:
        """One sample: specific force m/s², rate rad/s, temperature."""
        self._sum += physical
        self._count += 1

    def write(self, registers: bytearray) -> None:
        """Put the negated mean errors into the OFFSET registers."""
        if not self._count:
            return
        mean = self._sum / self._count
        for axis, target in self.axes.items():
            error = mean[axis] / STANDARD_GRAVITY - target
            code = _limited(-error / ACCEL_OFFSET_LSB_G, 8)
            registers[OFFSET_0 + axis] = code & 0xFF
        for axis in range(3) if self.gyro else ():
            code = _limited(-mean[3 + axis] * 180.0 / pi / GYRO_OFFSET_LSB_DEGREES, 10)
            registers[OFFSET_0 + 3 + axis] = code & 0xFF
            kept = registers[OFFSET_6] & ~(3 << 2 * axis)
            registers[OFFSET_6] = kept | (code >> 8 & 3) << 2 * axis


def _limited(value: float, bits: int) -> int:
    limit = 1 << (bits - 1)
    return max(-limit, min(limit - 1, round(value)))
