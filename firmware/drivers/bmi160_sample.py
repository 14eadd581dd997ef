"""From the BMI160's burst of 0x0C … 0x1A to SI units: pure conversion, one kernel call.

The burst as it lies in the driver's buffer: byte 0 is the address byte's slot, then gyro x, y, z,
accelerometer x, y, z (16 bits each, low byte first) and sensortime (24 bits, low byte first); fact sheet
sections 3 and 4. Ranges are those that `firmware.drivers.bmi160` sets: ±250 °/s and ±4 g.
"""

import math

import numpy as np

from firmware.numerics.dialect import kernel

BURST_LENGTH = 16
"""Address byte and the 15 registers from GYR_X_L to SENSORTIME_2."""

RAD_PER_LSB = np.float32(math.pi / 180.0 / 131.2)
"""At ±250 °/s: 131.2 LSB per °/s."""
METRE_PER_S2_PER_LSB = np.float32(9.80665 / 8192.0)
"""At ±4 g: 8192 LSB per g."""


@kernel
def signed_16(low, high):
    """Two's complement of two bytes."""
    value = np.int32(low) | np.int32(np.int64(high) << np.int64(8))
    return np.float32(value - np.int32(65536) if value >= np.int32(32768) else value)


@kernel
def rate_and_force(raw):
    """(ω x, y, z in rad/s, f x, y, z in m/s²), sensor axes, of a burst."""
    return (
        signed_16(raw[1], raw[2]) * RAD_PER_LSB,
        signed_16(raw[3], raw[4]) * RAD_PER_LSB,
        signed_16(raw[5], raw[6]) * RAD_PER_LSB,
        signed_16(raw[7], raw[8]) * METRE_PER_S2_PER_LSB,
        signed_16(raw[9], raw[10]) * METRE_PER_S2_PER_LSB,
        signed_16(raw[11], raw[12]) * METRE_PER_S2_PER_LSB,
    )


@kernel
def sensortime(raw):
    """The 24-bit counter of 39.0625 µs ticks."""
    return np.int64(raw[13]) | (np.int64(raw[14]) << np.int64(8)) | (np.int64(raw[15]) << np.int64(16))
