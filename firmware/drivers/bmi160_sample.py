"""From the BMI160's burst of 0x0C … 0x1A to SI units: pure conversion in the kernel dialect.

The burst as it lies in the driver's buffer: byte 0 is the address byte's slot, then gyro x, y, z,
accelerometer x, y, z (16 bits each, low byte first) and sensortime (24 bits, low byte first); fact sheet
sections 3, 4 and 7.

    ω = count · π/180 / (LSB per °/s),   f = count · g / (LSB per g),   Δt = (n₂ − n₁ mod 2²⁴) · 39.0625 µs
"""

import math

import numpy as np
from numpy.typing import NDArray

from firmware.drivers.signed_words import signed_16
from firmware.numerics.dialect import kernel

BURST_LENGTH = 16
"""Address byte and the 15 registers from GYR_X_L to SENSORTIME_2."""

STANDARD_GRAVITY = 9.80665
LSB_PER_DPS = {2000: 16.4, 1000: 32.8, 500: 65.6, 250: 131.2, 125: 262.4}
"""Gyro range in °/s: section 4."""
LSB_PER_G = {2: 16384.0, 4: 8192.0, 8: 4096.0, 16: 2048.0}

DEFAULT_GYRO_RANGE_DPS = 250
DEFAULT_ACCEL_RANGE_G = 4
RAD_PER_LSB = np.float32(math.pi / 180.0 / LSB_PER_DPS[DEFAULT_GYRO_RANGE_DPS])
RANGE_END = 32_750
"""Counts; a reading beyond is at the end of its range (32,767), or so near that it may have been there."""
METRE_PER_S2_PER_LSB = np.float32(STANDARD_GRAVITY / LSB_PER_G[DEFAULT_ACCEL_RANGE_G])

TWO_TICKS_NS = 78_125
"""A tick of the sensortime is 39.0625 µs."""
SENSORTIME_MASK = 0xFFFFFF

# A converted sample.
OMEGA = 0
"""ω x, y, z in rad/s, sensor axes."""
FORCE = 3
"""f x, y, z in m/s², sensor axes."""
SAMPLE_SIZE = 6


def scales(gyro_range_dps: int, accel_range_g: int) -> NDArray[np.float32]:
    """(rad/s per LSB, m/s² per LSB) of two ranges that the chip has."""
    rate = math.pi / 180.0 / LSB_PER_DPS[gyro_range_dps]
    force = STANDARD_GRAVITY / LSB_PER_G[accel_range_g]
    return np.array([rate, force], np.float32)


@kernel
def scaled(raw, rate, force):
    """(ω x, y, z, f x, y, z) of a burst, with the units of a count."""
    return (
        signed_16(raw[1], raw[2]) * rate,
        signed_16(raw[3], raw[4]) * rate,
        signed_16(raw[5], raw[6]) * rate,
        signed_16(raw[7], raw[8]) * force,
        signed_16(raw[9], raw[10]) * force,
        signed_16(raw[11], raw[12]) * force,
    )


@kernel
def rate_and_force(raw):
    """(ω x, y, z in rad/s, f x, y, z in m/s²), sensor axes, of a burst at the default ranges."""
    return scaled(raw, RAD_PER_LSB, METRE_PER_S2_PER_LSB)


@kernel
def sensortime(raw):
    """The 24-bit counter of 39.0625 µs ticks."""
    return np.int64(raw[13]) | (np.int64(raw[14]) << np.int64(8)) | (np.int64(raw[15]) << np.int64(16))


@kernel("int64(int64, int64)")
def nanoseconds_between(before, now):
    """Time from one sensortime to a later one, less than its wrap of 655 s away, by the chip's clock."""
    return (((now - before) & SENSORTIME_MASK) * TWO_TICKS_NS) >> 1


@kernel("int64(uint8[::1], float32[::1], float32[::1])")
def convert(raw, scale, sample):
    """Fill `sample` (SAMPLE_SIZE) from a burst, at the `scales` of its ranges. Returns its sensortime."""
    wx, wy, wz, fx, fy, fz = scaled(raw, scale[0], scale[1])
    sample[OMEGA] = wx
    sample[OMEGA + 1] = wy
    sample[OMEGA + 2] = wz
    sample[FORCE] = fx
    sample[FORCE + 1] = fy
    sample[FORCE + 2] = fz
    return sensortime(raw)
