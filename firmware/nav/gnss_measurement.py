"""What a GNSS epoch measures of the error state, compared where it is valid.

Let Δt be the age of the epoch, s = ∫f_n dt since then (velocity change less gravity), L = C_n_b l the lever
arm and W = C_n_b (ω × l) its velocity. With the state looked up in the history (r, v) the residuals are

    z_r = r_gnss − (r + L) − e_gnss     = δr − Δt δv + φ × (L + s Δt/2) − Δt²/2 C δb_a + δe_gnss − v δτ
    z_v = v_gnss − (v + W)              = δv + φ × (W − s) + Δt C δb_a − a δτ

all errors on the right being those of now; process noise within Δt (at most 1 s) is left out. τ is the
latency that the time tag did not allow for. When the receiver tells speed and course only, the two horizontal
rows are turned to along and across the course, where their noise is independent.
"""

import numpy as np

from firmware.drivers import gnss_epoch as gnss
from firmware.nav import layout as at
from firmware.nav import tuning as cfg
from firmware.nav.history import seconds_between
from firmware.numerics.dialect import kernel
from firmware.numerics.fixed_position import metres_east, metres_north, units_of_nanodegrees
from firmware.numerics.quaternion import rotation_matrix
from firmware.numerics.trigonometry import sine_cosine

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
MILLI = np.float32(1.0e-3)
RADIANS_PER_E5DEG = np.float32(1.7453292519943295e-7)
THREE = np.int32(3)
N = np.int32(at.STATES)
VELOCITY_ROW = 3


@kernel
def position_rows(f, i, e, time):
    """Rows, residuals of position to rows 0 … 2; the velocity of the antenna serves latency."""
    dt = seconds_between(time, i[at.TIME])
    lx, ly, lz = _turned_lever_arm(f)
    sx, sy, sz = _force_since(f, dt)
    half = HALF * dt
    _cross_rows(f, 0, lx + half * sx, ly + half * sy, lz + half * sz)
    accel = -half * dt
    for k in range(THREE):
        row = at.ROWS + k * at.STATES
        f[row + at.X_POSITION + k] = ONE
        f[row + at.X_VELOCITY + k] = -dt
        for m in range(THREE):
            f[row + at.X_ACCEL_BIAS + m] = accel * f[at.SINCE_C_N_B + 3 * k + m]
        f[row + at.X_GNSS_ERROR + k] = ONE
        f[row + at.X_LATENCY] = -f[at.AGO_VELOCITY + k]
    north = metres_north(units_of_nanodegrees(e[gnss.LAT_NANODEG]), i[at.AGO_LATITUDE], f[at.MERIDIAN_RADIUS])
    east = metres_east(units_of_nanodegrees(e[gnss.LON_NANODEG]), i[at.AGO_LONGITUDE], f[at.PARALLEL_RADIUS])
    down = f[at.AGO_HEIGHT] - epoch_height(e)
    f[at.RESIDUAL] = north - lx - f[at.GNSS_ERROR]
    f[at.RESIDUAL + 1] = east - ly - f[at.GNSS_ERROR + 1]
    f[at.RESIDUAL + 2] = down - lz - f[at.GNSS_ERROR + 2]


@kernel
def velocity_rows(f, i, e, time):
    """Rows and residuals of velocity NED to rows 3 … 5."""
    dt = seconds_between(time, i[at.TIME])
    wx, wy, wz = lever_arm_velocity(f)
    sx, sy, sz = _force_since(f, dt)
    _cross_rows(f, VELOCITY_ROW, wx - sx, wy - sy, wz - sz)
    for k in range(THREE):
        row = at.ROWS + (VELOCITY_ROW + k) * at.STATES
        f[row + at.X_VELOCITY + k] = ONE
        for m in range(THREE):
            f[row + at.X_ACCEL_BIAS + m] = dt * f[at.SINCE_C_N_B + 3 * k + m]
        f[row + at.X_LATENCY] = -f[at.AGO_ACCELERATION + k]
    north, east, down = epoch_velocity(e)
    f[at.RESIDUAL + 3] = north - f[at.AGO_VELOCITY] - wx
    f[at.RESIDUAL + 4] = east - f[at.AGO_VELOCITY + 1] - wy
    f[at.RESIDUAL + 5] = down - f[at.AGO_VELOCITY + 2] - wz


@kernel
def turn_velocity_rows(f, e):
    """Rows 3 and 4 from north and east to along and across the course."""
    s, c = sine_cosine(epoch_course(e))
    a = at.ROWS + VELOCITY_ROW * at.STATES
    b = a + at.STATES
    for j in range(N):
        north = f[a + j]
        east = f[b + j]
        f[a + j] = c * north + s * east
        f[b + j] = c * east - s * north
    north = f[at.RESIDUAL + 3]
    east = f[at.RESIDUAL + 4]
    f[at.RESIDUAL + 3] = c * north + s * east
    f[at.RESIDUAL + 4] = c * east - s * north


@kernel
def _cross_rows(f, first, mx, my, mz):
    """Attitude part of three rows: φ × m."""
    row = at.ROWS + first * at.STATES + at.X_ATTITUDE
    f[row + 1] = mz
    f[row + 2] = -my
    row += at.STATES
    f[row] = -mz
    f[row + 2] = mx
    row += at.STATES
    f[row] = my
    f[row + 1] = -mx


@kernel
def _force_since(f, dt):
    """∫f_n dt from the epoch to now."""
    return (
        f[at.VELOCITY] - f[at.AGO_VELOCITY],
        f[at.VELOCITY + 1] - f[at.AGO_VELOCITY + 1],
        f[at.VELOCITY + 2] - f[at.AGO_VELOCITY + 2] - f[at.GRAVITY] * dt,
    )


@kernel
def _turned_lever_arm(f):
    """C_n_b l with the attitude looked up."""
    return _turn(f, f[cfg.ANTENNA], f[cfg.ANTENNA + 1], f[cfg.ANTENNA + 2])


@kernel
def lever_arm_velocity(f):
    """C_n_b (ω × l) with attitude and rate looked up."""
    lx = f[cfg.ANTENNA]
    ly = f[cfg.ANTENNA + 1]
    lz = f[cfg.ANTENNA + 2]
    wx = f[at.AGO_RATE]
    wy = f[at.AGO_RATE + 1]
    wz = f[at.AGO_RATE + 2]
    return _turn(f, wy * lz - wz * ly, wz * lx - wx * lz, wx * ly - wy * lx)


@kernel
def _turn(f, x, y, z):
    q = at.AGO_QUATERNION
    c00, c01, c02, c10, c11, c12, c20, c21, c22 = rotation_matrix(f[q], f[q + 1], f[q + 2], f[q + 3])
    return c00 * x + c01 * y + c02 * z, c10 * x + c11 * y + c12 * z, c20 * x + c21 * y + c22 * z


@kernel
def epoch_height(e):
    """m above the ellipsoid; a fraction of a millimetre is lost above 8 km."""
    return np.float32(np.int32(e[gnss.HEIGHT_MM])) * MILLI


@kernel
def epoch_course(e):
    """Course over ground, rad."""
    return np.float32(np.int32(e[gnss.COURSE_E5DEG])) * RADIANS_PER_E5DEG


@kernel
def epoch_velocity(e):
    """Velocity NED in m/s: as told, or from speed and course, then 0 down."""
    if e[gnss.FLAGS] & gnss.HAS_VELOCITY:
        return (
            np.float32(np.int32(e[gnss.VEL_N_MMPS])) * MILLI,
            np.float32(np.int32(e[gnss.VEL_E_MMPS])) * MILLI,
            np.float32(np.int32(e[gnss.VEL_D_MMPS])) * MILLI,
        )
    speed = np.float32(np.int32(e[gnss.SPEED_MMPS])) * MILLI
    if e[gnss.FLAGS] & gnss.HAS_COURSE:
        s, c = sine_cosine(epoch_course(e))
        return speed * c, speed * s, ZERO
    return speed, ZERO, ZERO
