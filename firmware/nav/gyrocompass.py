"""Yaw from the Earth's rate: for a start without an attitude reference, with gyros that can feel it.

At rest the mean rate in level axes n' (yaw 0) is that of the Earth, seen under the yaw ψ of the body:

    ω_x' = Ω cos L cos ψ        ω_y' = −Ω cos L sin ψ        ψ = atan2(−ω_y', ω_x')
    σ_ψ² = (σ_b² + σ_r² + N²/T + 2 (v/g)²/T²) / (Ω cos L)² + (σ_a tan L / g)²

after the time T, with gyro bias σ_b and its instability σ_r, angle random walk N, accelerometer bias σ_a. A
vehicle rocks while people get in: what it has tilted from the first window to the last, as the specific force
tells (v: its noise over a window), is no rotation of the Earth. Yaw found so has the error
φ_D = b_E / (Ω cos L): exactly what nulls the east gyro bias b_E, and it is tied to it in the covariance. See
Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., section 5.6.2.
"""

import numpy as np

from firmware.nav import layout as at
from firmware.nav import reference_layout as ref
from firmware.nav import tuning as cfg
from firmware.nav.covariance import add_along_gain
from firmware.nav.earth import EARTH_RATE, LEAST_COS
from firmware.nav.flags import WAITING_FOR_HEADING
from firmware.nav.heading import begin_after_rest
from firmware.numerics.dialect import kernel
from firmware.numerics.fixed_position import radians_of_units
from firmware.numerics.quaternion import rotate_vector
from firmware.numerics.trigonometry import arc_tangent2, sine_cosine

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
UNKNOWN_VARIANCE = np.float32(9.8696044010894)
"""π²: before anything is known."""
THREE = np.int32(3)


@kernel
def gather_rest(f, i):
    """Add the window just closed (layout.WINDOW_MEAN) to the rest, or forget the rest at the next one."""
    if i[at.LEVEL_WINDOWS] == 0:
        return
    m = at.WINDOW_MEAN
    if i[at.LEVEL_WINDOWS] == 1:
        f[ref.COMPASS_SECONDS] = ZERO
        for k in range(THREE):
            f[ref.COMPASS_SUM + k] = ZERO
            f[ref.FIRST_FORCE + k] = f[m + 3 + k]
    f[ref.COMPASS_SECONDS] += f[cfg.WINDOW]
    for k in range(THREE):
        f[ref.COMPASS_SUM + k] += f[m + k] * f[cfg.WINDOW]
        f[ref.LAST_FORCE + k] = f[m + 3 + k]


@kernel
def mean_rate_at_rest(f):
    """Mean rate of the rest, body axes, without what the body tilted meanwhile."""
    a = ref.FIRST_FORCE
    b = ref.LAST_FORCE
    per_square = ONE / max(f[b] * f[b] + f[b + 1] * f[b + 1] + f[b + 2] * f[b + 2], ONE)
    dx = f[b] - f[a]
    dy = f[b + 1] - f[a + 1]
    dz = f[b + 2] - f[a + 2]
    per_time = ONE / f[ref.COMPASS_SECONDS]
    s = ref.COMPASS_SUM
    return (
        (f[s] - (dy * f[b + 2] - dz * f[b + 1]) * per_square) * per_time,
        (f[s + 1] - (dz * f[b] - dx * f[b + 2]) * per_square) * per_time,
        (f[s + 2] - (dx * f[b + 1] - dy * f[b]) * per_square) * per_time,
    )


@kernel
def compass_variance(f, i):
    """σ_ψ² of the rest gathered so far."""
    time = f[ref.COMPASS_SECONDS]
    if not time > ZERO or not f[cfg.GYRO_VARIANCE] > ZERO or i[at.FIX_TIME] == at.NEVER:
        return UNKNOWN_VARIANCE
    s, c = sine_cosine(radians_of_units(i[at.FIX_LATITUDE]))
    c = max(c, LEAST_COS)
    per_g = ONE / f[cfg.STANDARD_GRAVITY]
    tilt = TWO * f[cfg.VELOCITY_WALK_VARIANCE] / f[cfg.WINDOW] * per_g * per_g
    rate = f[cfg.GYRO_VARIANCE] + f[cfg.GYRO_INSTABILITY_VARIANCE]
    rate += (f[cfg.ANGLE_WALK_VARIANCE] + tilt / time) / time
    level = f[cfg.ACCEL_BIAS_VARIANCE] * (s * per_g) * (s * per_g)
    per_c = ONE / c
    return min((rate / (EARTH_RATE * EARTH_RATE) + level) * per_c * per_c, UNKNOWN_VARIANCE)


@kernel
def compass_turn(f):
    """ψ of the level axes: what turns them to north."""
    x, y, z = mean_rate_at_rest(f)
    q = at.REST_QUATERNION
    level_x, level_y, _ = rotate_vector(f[q], f[q + 1], f[q + 2], f[q + 3], x, y, z)
    return arc_tangent2(-level_y, level_x)


@kernel
def compass_is_due(f, i):
    """Whether it has gathered long enough: at rest, or, when the vehicle has driven off, what there is."""
    if i[at.MODE] != WAITING_FOR_HEADING or not f[cfg.GYRO_VARIANCE] > ZERO or not f[ref.COMPASS_TIME] > ZERO:
        return False
    least = f[ref.COMPASS_TIME] if i[at.LEVEL_WINDOWS] > 0 else f[ref.COMPASS_LEAST_TIME]
    return f[ref.COMPASS_SECONDS] >= least


@kernel
def begin_by_compass(f, i, e, time):
    """Navigate from the epoch `e`, valid at `time` and looked up, with the yaw of the gyros."""
    turn = compass_turn(f)
    variance = compass_variance(f, i)
    x, y, z = mean_rate_at_rest(f)
    f[at.REST_RATE] = x
    f[at.REST_RATE + 1] = y
    f[at.REST_RATE + 2] = z
    f[at.REST_TIME] = f[ref.COMPASS_SECONDS]
    begin_after_rest(f, i, e, time, turn, ZERO)
    per_earth_rate = ONE / f[at.EARTH_RATE_N]
    of_bias = f[cfg.GYRO_VARIANCE] * per_earth_rate * per_earth_rate
    for k in range(np.int32(at.X_GYRO_BIAS)):
        f[at.GAIN + k] = ZERO
    f[at.GAIN + at.X_ATTITUDE + 2] = per_earth_rate
    for k in range(THREE):
        f[at.GAIN + at.X_GYRO_BIAS + k] = f[at.C_N_B + 3 + k]
    add_along_gain(f, at.X_GYRO_BIAS + 2, f[cfg.GYRO_VARIANCE])
    for k in range(np.int32(at.X_ATTITUDE + 2)):
        f[at.GAIN + k] = ZERO
    f[at.GAIN + at.X_ATTITUDE + 2] = ONE
    add_along_gain(f, at.X_ATTITUDE + 2, max(variance - of_bias, ZERO))
