"""Static coarse alignment in fixed point; the formulas are those of `..alignment`.

The sums of the samples are 64 bits wide; only their directions count, so they are shifted, not divided.
"""

import numpy as np

from firmware.nav.attitude import flags as fl
from firmware.nav.attitude.fixed import layout as at
from firmware.nav.attitude.fixed.earth import refresh_earth
from firmware.nav.attitude.fixed.motion import set_matrix
from firmware.nav.attitude.fixed.samples import store
from firmware.numerics.dialect import kernel
from firmware.numerics.fixed.angles import arc_tangent2, sine_cosine, wrap
from firmware.numerics.fixed.arithmetic import leading_bit, rounded_shift, shifted
from firmware.numerics.fixed.quaternion import quaternion_of_euler
from firmware.numerics.fixed.roots import quotient, square_root

THREE = np.int32(3)
FORCE_SHIFT = 8
"""Off the force before it is squared."""
SUM_RATE = at.FIXED_SUMS
SUM_FORCE = at.FIXED_SUMS + 3
SUM_FIELD = at.FIXED_SUMS + 6


@kernel
def align(s, i, found):
    """Use the newest sample; returns `found` with MOVED and YAW_GIVEN where they belong."""
    if not is_at_rest(s):
        begin_alignment(i)
        return found | fl.MOVED
    plausible = found & fl.FIELD_IMPLAUSIBLE == 0
    for k in range(THREE):
        i[SUM_RATE + k] += np.int64(s[at.OMEGA + at.NEWEST + k])
        i[SUM_FORCE + k] += np.int64(s[at.FORCE + at.NEWEST + k])
        if plausible:
            i[SUM_FIELD + k] += np.int64(s[at.FIELD + k])
    if plausible:
        i[at.FIELD_COUNT] += 1
    i[at.ALIGNMENT_COUNT] += 1
    if i[at.ALIGNMENT_COUNT] >= i[at.ALIGNMENT_SAMPLES]:
        found |= finish_alignment(s, i)
    return found


@kernel
def begin_alignment(i):
    """No samples so far."""
    i[at.MODE] = fl.ALIGNING
    i[at.ALIGNMENT_COUNT] = 0
    i[at.FIELD_COUNT] = 0
    for k in range(np.int32(9)):
        i[at.FIXED_SUMS + k] = 0


@kernel
def is_at_rest(s):
    """Whether the newest sample can be one of a vehicle that stands."""
    turns = np.int64(0)
    square = np.int64(0)
    for k in range(THREE):
        turns = max(turns, abs(np.int64(s[at.OMEGA + at.NEWEST + k]) - np.int64(s[at.GYRO_BIAS + k])))
        part = np.int64(s[at.FORCE + at.NEWEST + k]) >> FORCE_SHIFT
        square += part * part
    gravity = np.int64(s[at.GRAVITY]) >> (at.Q_INCREMENT - at.Q_FORCE + FORCE_SHIFT)
    return (
        turns <= np.int64(s[at.REST_RATE])
        and abs(square_root(square) - gravity) <= np.int64(s[at.REST_FORCE]) >> FORCE_SHIFT
    )


@kernel
def same_direction(i, k):
    """Three sums shifted alike until the largest has 30 bits."""
    largest = max(max(abs(i[k]), abs(i[k + 1])), abs(i[k + 2]))
    bits = 29 - leading_bit(largest)
    return shifted(i[k], bits), shifted(i[k + 1], bits), shifted(i[k + 2], bits)


@kernel
def finish_alignment(s, i):
    """Attitude of the sums; the newest sample begins the first iteration. Returns YAW_GIVEN or 0."""
    found = np.int64(0)
    fx, fy, fz = same_direction(i, SUM_FORCE)
    roll = arc_tangent2(-fy, -fz)
    pitch = arc_tangent2(fx, square_root(fy * fy + fz * fz))
    yaw = np.int64(s[at.GIVEN_YAW])
    if i[at.USE_FIELD] != 0:
        if i[at.FIELD_COUNT] * 2 >= i[at.ALIGNMENT_COUNT]:
            yaw = wrap(magnetic_yaw(i, pitch, roll) + np.int64(s[at.DECLINATION]))
        else:
            found = np.int64(fl.YAW_GIVEN)
    w, x, y, z = quaternion_of_euler(yaw, pitch, roll)
    kind = fl.SATURATED_ATTITUDE
    store(s, i, at.QUATERNION, kind, w)
    store(s, i, at.QUATERNION + 1, kind, x)
    store(s, i, at.QUATERNION + 2, kind, y)
    store(s, i, at.QUATERNION + 3, kind, z)
    set_matrix(s, i)
    refresh_earth(s, i)
    if i[at.NULL_GYROS] != 0:
        null_gyros(s, i)
    i[at.MODE] = fl.RUNNING
    i[at.IN_RING] = 1
    for k in range(THREE):
        s[at.VELOCITY + k] = np.int32(0)
    return found


@kernel
def magnetic_yaw(i, pitch, roll):
    """Binary angle from the magnetic north to the body's front."""
    mx, my, mz = same_direction(i, SUM_FIELD)
    sr, cr = sine_cosine(roll)
    sp, cp = sine_cosine(pitch)
    down = rounded_shift(my * sr + mz * cr, 30)
    return arc_tangent2(rounded_shift(mz * sr - my * cr, 30), rounded_shift(mx * cp + down * sp, 30))


@kernel
def null_gyros(s, i):
    """GYRO_BIAS: the mean rate less that of the Earth."""
    for k in range(THREE):
        total = i[SUM_RATE + k]
        bits = max(leading_bit(abs(total)) - 29, np.int64(0))
        part = total >> bits
        mean = quotient(part, i[at.ALIGNMENT_COUNT], bits)
        c = at.C_N_B + k
        earth = np.int64(s[c]) * np.int64(s[at.EARTH_RATE_N]) + np.int64(s[c + 6]) * np.int64(
            s[at.EARTH_RATE_D]
        )
        mean -= rounded_shift(earth, at.Q_UNIT + at.Q_EARTH_RATE - at.Q_RATE)
        store(s, i, at.GYRO_BIAS + k, fl.SATURATED_RATE, mean)
