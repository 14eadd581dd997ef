"""From the ADIS16407's burst to SI units: pure conversion in the kernel dialect.

The burst as it lies in the driver's buffer: the word of the request, then SUPPLY_OUT, gyro, accelerometer and
magnetometer x, y, z, BARO_OUT, BARO_OUTL, TEMP_OUT, AUX_ADC; 16 bits each, high byte first. Bit 15 says new
data, bit 14 an error or alarm, the value stands below (fact sheet sections 2 to 4).

    ω = count · 0.05 °/s · range/300,   f = count · g/300,   B = count · 0.5 mgauss,
    p = (BARO_OUT · 256 + BARO_OUTL) · 0.03125 Pa,   T = 25 °C + count · 0.136 K
"""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from firmware.numerics.dialect import kernel

BURST_LENGTH: Final = 30
STANDARD_GRAVITY: Final = 9.80665

# A converted sample.
OMEGA: Final = 0
"""ω x, y, z in rad/s, sensor axes."""
FORCE: Final = 3
"""f x, y, z in m/s²."""
FIELD: Final = 6
"""Magnetic flux density x, y, z in T."""
PRESSURE: Final = 9
"""Pa."""
TEMPERATURE: Final = 10
"""°C."""
SUPPLY: Final = 11
"""V."""
ADC: Final = 12
"""V."""
SAMPLE_SIZE: Final = 13

NEW: Final = 1
ERROR: Final = 2
"""What `convert` returns: every register was new; the chip reports an error or alarm."""

DEFAULT_GYRO_RANGE_DPS: Final = 300
PASCAL: Final = np.float32(0.03125)
KELVIN: Final = np.float32(0.136)
ZERO_C: Final = np.float32(25.0)
TESLA: Final = np.float32(0.5e-7)
SUPPLY_VOLT: Final = np.float32(2.418e-3)
ADC_VOLT: Final = np.float32(0.806e-3)


def scales(gyro_range_dps: int = DEFAULT_GYRO_RANGE_DPS) -> NDArray[np.float32]:
    """(rad/s a count, m/s² a count) of a gyro range."""
    return np.array([math.radians(0.05) * gyro_range_dps / 300.0, STANDARD_GRAVITY / 300.0], np.float32)


@kernel
def word(raw, at):
    """The 16 bits at a byte index."""
    return (np.int64(raw[at]) << 8) | np.int64(raw[at + 1])


@kernel
def signed_14(raw, at):
    """Two's complement of the lowest 14 bits, as float32."""
    left = np.int32((word(raw, at) & 0x3FFF) << 18)
    return np.float32(np.int32(left >> 18))


@kernel
def pressure(raw):
    """Pa, out of both words; the counts have 22 bits, which float32 holds exactly."""
    counts = ((word(raw, 22) & 0x3FFF) << 8) | (word(raw, 24) & 0xFF)
    return np.float32(np.int32(counts)) * PASCAL


@kernel
def temperature(raw):
    """°C, of the lowest 12 bits."""
    left = np.int32((word(raw, 26) & 0xFFF) << 20)
    return ZERO_C + np.float32(np.int32(left >> 20)) * KELVIN


@kernel
def flags(raw):
    """NEW when all 14 registers were, ERROR when any says so."""
    new = np.int64(0x8000)
    error = np.int64(0)
    for k in range(np.int32(14)):
        value = word(raw, 2 + 2 * k)
        new = new & value
        error = error | (value & 0x4000)
    return (NEW if new else np.int64(0)) | (ERROR if error else np.int64(0))


@kernel("int64(uint8[::1], float32[::1], float32[::1])")
def convert(raw, scale, sample):
    """Fill `sample` (SAMPLE_SIZE) from a burst, at the `scales` of its range. Returns NEW and ERROR."""
    for k in range(np.int32(3)):
        sample[OMEGA + k] = signed_14(raw, 4 + 2 * k) * scale[0]
        sample[FORCE + k] = signed_14(raw, 10 + 2 * k) * scale[1]
        sample[FIELD + k] = signed_14(raw, 16 + 2 * k) * TESLA
    sample[PRESSURE] = pressure(raw)
    sample[TEMPERATURE] = temperature(raw)
    sample[SUPPLY] = np.float32(np.int32(word(raw, 2) & 0xFFF)) * SUPPLY_VOLT
    sample[ADC] = np.float32(np.int32(word(raw, 28) & 0xFFF)) * ADC_VOLT
    return flags(raw)
