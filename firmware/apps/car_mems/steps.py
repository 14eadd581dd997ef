"""What the navigation task does with a sample: one kernel call from raw registers to the new state."""

import numpy as np

from firmware.apps.car_mems.sample_clock import TIME, sample_time
from firmware.drivers.bmi160_sample import rate_and_force, sensortime
from firmware.nav import layout
from firmware.nav import tuning as cfg
from firmware.nav.flags import IMU_GAP, report
from firmware.nav.imu import imu_step
from firmware.numerics.dialect import kernel
from firmware.numerics.wide_integers import float32_of_int64

CLOCK_AT = np.int32(layout.I_SIZE)
"""Where the sample clock lies in `i`."""
MEAN_AT = np.int32(layout.F_SIZE)
"""Where the sums of ω and f (6) and their number lie in `f`."""
MEAN_COUNT = np.int32(layout.F_SIZE + 6)
LAST_AT = np.int32(layout.F_SIZE + 7)
"""Where the last sample that was believed lies in `f` (6), behind it the last one refused (6), and how many
were refused in a row."""
REFUSED_AT = np.int32(layout.F_SIZE + 13)
REFUSED = np.int32(layout.F_SIZE + 19)
APP_SIZE = 20
"""What this program keeps in `f` behind navigation."""

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TENTH = np.float32(0.1)
TEN = np.float32(10.0)
NANO = np.float32(1.0e-9)
NOMINAL_NS = np.int64(10_000_000)
RATE_STEP = np.float32(0.35)
"""rad/s between two samples: 2000 °/s², which no car does."""
FORCE_STEP = np.float32(15.0)
"""m/s² between two samples, above vibration of 3 m/s² RMS up to 15 Hz."""
SPOILT = np.float32(1.0e6)
"""In place of a reading at the end of its range: the mean that it goes into is beyond the range, too."""
MOST_REFUSED = np.float32(10.0)
"""In a row; what goes on for a tenth of a second is no disturbance of single samples."""


@kernel
def jumps(f, p, wx, wy, wz, ax, ay, az):
    """Whether the sample is further from the one at `p` than two in a row can be."""
    rate = max(max(abs(wx - f[p]), abs(wy - f[p + 1])), abs(wz - f[p + 2]))
    force = max(max(abs(ax - f[p + 3]), abs(ay - f[p + 4])), abs(az - f[p + 5]))
    return rate > RATE_STEP or force > FORCE_STEP


@kernel
def keep_sample(f, p, wx, wy, wz, ax, ay, az):
    """Store it at `p`."""
    f[p] = wx
    f[p + 1] = wy
    f[p + 2] = wz
    f[p + 3] = ax
    f[p + 4] = ay
    f[p + 5] = az


@kernel
def without_spike(f, i, wx, wy, wz, ax, ay, az):
    """The sample, or the last one believed again where it jumps: the bus has no checksum.

    A jump is believed when the sample before jumped to the same place, it is no bit error.
    """
    p = LAST_AT
    if jumps(f, p, wx, wy, wz, ax, ay, az):
        alone = f[REFUSED] == ZERO or jumps(f, REFUSED_AT, wx, wy, wz, ax, ay, az)
        if alone and f[REFUSED] < MOST_REFUSED:
            keep_sample(f, REFUSED_AT, wx, wy, wz, ax, ay, az)
            f[REFUSED] += ONE
            report(i, IMU_GAP)
            return f[p], f[p + 1], f[p + 2], f[p + 3], f[p + 4], f[p + 5]
    f[REFUSED] = ZERO
    keep_sample(f, p, wx, wy, wz, ax, ay, az)
    return wx, wy, wz, ax, ay, az


@kernel("int64(float32[::1], int64[::1], uint8[::1], int64)")
def data_ready_step(f, i, raw, t_read_ns):
    """`full-rate`: one strapdown step from the burst `raw` that was read at `t_read_ns`.

    Returns the time since the sample before in ns; 0: this sample had been read already and is left alone.
    """
    span = sample_time(i, CLOCK_AT, sensortime(raw), t_read_ns)
    if span == np.int64(0):
        return span
    if span < np.int64(0):
        span = NOMINAL_NS
    wx, wy, wz, ax, ay, az = rate_and_force(raw)
    wx, wy, wz, ax, ay, az = without_spike(f, i, wx, wy, wz, ax, ay, az)
    imu_step(f, i, i[CLOCK_AT + TIME], float32_of_int64(span) * NANO, wx, wy, wz, ax, ay, az)
    return span


@kernel("int64(float32[::1], int64[::1], uint8[::1], int64)")
def timer_sample(f, i, raw, t_read_ns):
    """`thesis`: add the burst `raw` to the mean; every tenth makes a strapdown step of 0.1 s.

    The processor's timer gives the times; the sample clock only counts samples missed and read twice, which
    go into the mean as they come. Returns 1 when a step was made.
    """
    sample_time(i, CLOCK_AT, sensortime(raw), t_read_ns)
    wx, wy, wz, ax, ay, az = rate_and_force(raw)
    wx, wy, wz, ax, ay, az = without_spike(f, i, wx, wy, wz, ax, ay, az)
    if max(max(abs(wx), abs(wy)), abs(wz)) > f[cfg.RATE_LIMIT]:
        wx = SPOILT
    if max(max(abs(ax), abs(ay)), abs(az)) > f[cfg.ACCEL_LIMIT]:
        ax = SPOILT
    f[MEAN_AT] += wx
    f[MEAN_AT + 1] += wy
    f[MEAN_AT + 2] += wz
    f[MEAN_AT + 3] += ax
    f[MEAN_AT + 4] += ay
    f[MEAN_AT + 5] += az
    f[MEAN_COUNT] += ONE
    if f[MEAN_COUNT] < TEN:
        return np.int64(0)
    wx = f[MEAN_AT] * TENTH
    wy = f[MEAN_AT + 1] * TENTH
    wz = f[MEAN_AT + 2] * TENTH
    ax = f[MEAN_AT + 3] * TENTH
    ay = f[MEAN_AT + 4] * TENTH
    az = f[MEAN_AT + 5] * TENTH
    for k in range(np.int32(7)):
        f[MEAN_AT + k] = ZERO
    imu_step(f, i, t_read_ns, TENTH, wx, wy, wz, ax, ay, az)
    return np.int64(1)
