"""What the navigation task does with a sample: one kernel call from increments to the new state."""

import numpy as np

from firmware.drivers import serial_imu_frames as fr
from firmware.nav.imu import imu_step
from firmware.numerics.dialect import kernel

RAD_PER_S = np.float32(2.0e-7)
"""Of a unit of Δθ, 10⁻⁹ rad in 5 ms."""
METRE_PER_S2 = np.float32(2.0e-6)
"""Of a unit of Δv, 10⁻⁸ m/s in 5 ms."""
PERIOD = np.float32(0.005)
MOST_PERIODS = np.int64(2)
"""One sample missing by the counter is taken to have been like the next; more are dead time to navigation."""
SPOILT = np.float32(1.0e6)
"""In place of a mean that the unit calls clipped: beyond every range."""


@kernel
def mean_of(sample, place, unit):
    """One increment as the mean over its period."""
    return np.float32(np.int32(sample[place])) * unit


@kernel("int64(float32[::1], int64[::1], int64[::1])")
def sample_step(f, i, sample):
    """One strapdown step from a sample (`serial_imu_frames`) with the time of its validity in END_NS.

    Returns 1; 0: the unit is starting, its sample was left alone.
    """
    status = sample[fr.STATUS]
    if status & (fr.STARTING | fr.SELF_TEST_FAILED) != 0:
        return np.int64(0)
    wx = mean_of(sample, fr.ANGLE, RAD_PER_S)
    wy = mean_of(sample, fr.ANGLE + 1, RAD_PER_S)
    wz = mean_of(sample, fr.ANGLE + 2, RAD_PER_S)
    ax = mean_of(sample, fr.VELOCITY, METRE_PER_S2)
    ay = mean_of(sample, fr.VELOCITY + 1, METRE_PER_S2)
    az = mean_of(sample, fr.VELOCITY + 2, METRE_PER_S2)
    if status & fr.GYRO_RANGE != 0:
        wx = SPOILT
    if status & fr.ACCEL_RANGE != 0:
        ax = SPOILT
    periods = np.float32(np.int32(min(sample[fr.MISSED] + 1, MOST_PERIODS)))
    imu_step(f, i, sample[fr.END_NS], PERIOD * periods, wx, wy, wz, ax, ay, az)
    return np.int64(1)
