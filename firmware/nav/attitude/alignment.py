"""Static coarse alignment: attitude from means of specific force and magnetic field at rest.

    roll = atan2(−f_y, −f_z)     pitch = atan2(f_x, √(f_y² + f_z²))
    yaw  = atan2(−m_y', m_x') + declination, m' = m_b turned back by pitch and roll

A sample that is not at rest begins the sums anew. Without a field that can be the Earth's in half of the
samples yaw is the one given. With NULL_GYROS the mean rate less that of the Earth becomes the gyro bias.
"""

import math

import numpy as np

from firmware.nav.attitude import flags as fl
from firmware.nav.attitude import layout as at
from firmware.nav.attitude.motion import refresh_earth, set_matrix
from firmware.numerics.dialect import kernel
from firmware.numerics.quaternion import quaternion_of_euler, wrap_heading
from firmware.numerics.trigonometry import arc_tangent2, sine_cosine

ZERO = np.float32(0.0)
THREE = np.int32(3)


@kernel
def align(s, i, found):
    """Use the newest sample; returns `found` with MOVED and YAW_GIVEN where they belong."""
    if not is_at_rest(s):
        begin_alignment(s, i)
        return found | fl.MOVED
    plausible = found & fl.FIELD_IMPLAUSIBLE == 0
    for k in range(THREE):
        s[at.SUM_OMEGA + k] += s[at.OMEGA + at.NEWEST + k]
        s[at.SUM_FORCE + k] += s[at.FORCE + at.NEWEST + k]
        if plausible:
            s[at.SUM_FIELD + k] += s[at.FIELD + k]
    if plausible:
        i[at.FIELD_COUNT] += 1
    i[at.ALIGNMENT_COUNT] += 1
    if i[at.ALIGNMENT_COUNT] >= i[at.ALIGNMENT_SAMPLES]:
        found |= finish_alignment(s, i)
    return found


@kernel
def begin_alignment(s, i):
    """No samples so far."""
    i[at.MODE] = fl.ALIGNING
    i[at.ALIGNMENT_COUNT] = 0
    i[at.FIELD_COUNT] = 0
    for k in range(np.int32(9)):
        s[at.SUM_OMEGA + k] = ZERO


@kernel
def is_at_rest(s):
    """Whether the newest sample can be one of a vehicle that stands."""
    turns = ZERO
    square = ZERO
    for k in range(THREE):
        turns = max(turns, abs(s[at.OMEGA + at.NEWEST + k] - s[at.GYRO_BIAS + k]))
        force = s[at.FORCE + at.NEWEST + k]
        square += force * force
    return turns <= s[at.REST_RATE] and abs(np.float32(math.sqrt(square)) - s[at.GRAVITY]) <= s[at.REST_FORCE]


@kernel
def finish_alignment(s, i):
    """Attitude of the sums; the newest sample begins the first iteration. Returns YAW_GIVEN or 0."""
    found = np.int64(0)
    fx = s[at.SUM_FORCE]
    fy = s[at.SUM_FORCE + 1]
    fz = s[at.SUM_FORCE + 2]
    roll = arc_tangent2(-fy, -fz)
    pitch = arc_tangent2(fx, np.float32(math.sqrt(fy * fy + fz * fz)))
    yaw = s[at.GIVEN_YAW]
    if i[at.USE_FIELD] != 0:
        if i[at.FIELD_COUNT] * 2 >= i[at.ALIGNMENT_COUNT]:
            yaw = wrap_heading(magnetic_yaw(s, pitch, roll) + s[at.DECLINATION])
        else:
            found = np.int64(fl.YAW_GIVEN)
    w, x, y, z = quaternion_of_euler(yaw, pitch, roll)
    s[at.QUATERNION] = w
    s[at.QUATERNION + 1] = x
    s[at.QUATERNION + 2] = y
    s[at.QUATERNION + 3] = z
    set_matrix(s)
    refresh_earth(s, i)
    if i[at.NULL_GYROS] != 0:
        null_gyros(s)
    start_running(s, i)
    return found


@kernel
def start_running(s, i):
    """Iterations begin with the newest sample, from standstill."""
    i[at.MODE] = fl.RUNNING
    i[at.IN_RING] = 1
    for k in range(THREE):
        s[at.VELOCITY + k] = ZERO


@kernel
def magnetic_yaw(s, pitch, roll):
    """Angle from the magnetic north to the body's front."""
    mx = s[at.SUM_FIELD]
    my = s[at.SUM_FIELD + 1]
    mz = s[at.SUM_FIELD + 2]
    sr, cr = sine_cosine(roll)
    sp, cp = sine_cosine(pitch)
    return arc_tangent2(mz * sr - my * cr, mx * cp + (my * sr + mz * cr) * sp)


@kernel
def null_gyros(s):
    """GYRO_BIAS: the mean rate less that of the Earth."""
    c = at.C_N_B
    for k in range(THREE):
        earth = s[c + k] * s[at.EARTH_RATE_N] + s[c + 6 + k] * s[at.EARTH_RATE_D]
        s[at.GYRO_BIAS + k] = s[at.SUM_OMEGA + k] * s[at.PER_ALIGNMENT] - earth
