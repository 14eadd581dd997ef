"""What a record of the attitude reference measures of the error state, compared where it is valid.

With C_n_a = C_n_b C_b_a at the time of validity and u its first column (the direction of the baseline), h its
level length, the angles of the reference's axes and what φ makes of them (u' = φ × u) are

    heading  ψ = atan2(u_E, u_N)      δψ = φ_D − u_D (u_N φ_N + u_E φ_E) / h²
    pitch    θ = atan2(−u_D, h)       δθ = (u_N φ_E − u_E φ_N) / h
    roll     atan2(C_32, C_33)        δγ = (u_N φ_N + u_E φ_E) / h²

The error φ is that of now: within the age of a record (at most a second) gyros add next to nothing.

A record's error is white plus first-order Gauss-Markov with the time T. It is judged with both as they stand.
The second is no state: gyros hold the heading so much longer than T that all they could tell of it is its
mean. So an update weighs it as a white error that has the same spectrum at low frequencies,
R = σ_w² + σ_c² 2T/Δt, Δt since such an angle was used last. A claimed accuracy
that is worse adds its excess to σ_w²; so does the rate of turn times the error of the time tag.
"""

import math

import numpy as np

from firmware.drivers import gnss_epoch as gnss
from firmware.nav import layout as at
from firmware.nav import reference_layout as ref
from firmware.nav import tuning as cfg
from firmware.nav.heading import wrap_pi
from firmware.nav.history import seconds_between
from firmware.numerics.dialect import kernel
from firmware.numerics.quaternion import rotation_matrix
from firmware.numerics.trigonometry import arc_tangent2

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
RADIANS_PER_E5DEG = np.float32(1.7453292519943295e-7)
LEAST_LEVEL = np.float32(0.2)
"""Level part of the baseline's direction: within 12 degrees of the vertical it has no heading."""
LEAST_SPACING = np.float32(0.02)
N = np.int32(at.STATES)
THREE = np.int32(3)


@kernel
def told_angle(e, angle):
    """Angle number `angle` of the record, rad, in (−π, π]."""
    return wrap_pi(np.float32(np.int32(e[gnss.HEADING_E5DEG + angle])) * RADIANS_PER_E5DEG)


@kernel
def told_mask(e):
    """Bit k: the record tells angle k."""
    flags = e[gnss.FLAGS]
    mask = np.int64(1) if flags & gnss.HAS_HEADING else np.int64(0)
    if flags & gnss.HAS_PITCH:
        mask |= np.int64(2)
    if flags & gnss.HAS_ROLL:
        mask |= np.int64(4)
    return mask


@kernel
def reference_rows(f):
    """Rows 0 … 2 and predicted angles for the attitude looked up; False when the baseline stands upright."""
    q = at.AGO_QUATERNION
    c00, c01, c02, c10, c11, c12, c20, c21, c22 = rotation_matrix(f[q], f[q + 1], f[q + 2], f[q + 3])
    m = ref.C_B_A
    north = c00 * f[m] + c01 * f[m + 3] + c02 * f[m + 6]
    east = c10 * f[m] + c11 * f[m + 3] + c12 * f[m + 6]
    down = c20 * f[m] + c21 * f[m + 3] + c22 * f[m + 6]
    side_down = c20 * f[m + 1] + c21 * f[m + 4] + c22 * f[m + 7]
    floor_down = c20 * f[m + 2] + c21 * f[m + 5] + c22 * f[m + 8]
    square = north * north + east * east
    level = np.float32(math.sqrt(square))
    if not level > LEAST_LEVEL:
        return False
    per_level = ONE / level
    per_square = per_level * per_level
    f[ref.PREDICTED] = arc_tangent2(east, north)
    f[ref.PREDICTED + 1] = arc_tangent2(-down, level)
    f[ref.PREDICTED + 2] = arc_tangent2(side_down, floor_down)
    for k in range(np.int32(ref.ANGLES * at.STATES)):
        f[at.ROWS + k] = ZERO
    h = at.ROWS + at.X_ATTITUDE
    f[h] = -down * north * per_square
    f[h + 1] = -down * east * per_square
    f[h + 2] = ONE
    h += at.STATES
    f[h] = -east * per_level
    f[h + 1] = north * per_level
    h += at.STATES
    f[h] = north * per_square
    f[h + 1] = east * per_square
    return True


@kernel
def single_variance(f, e, angle):
    """Variance of one angle of one record."""
    white = f[ref.WHITE_VARIANCE + angle]
    whole = white + f[ref.ERROR_VARIANCE + angle]
    claim = np.float32(np.int32(e[gnss.HEADING_SIGMA_E5DEG + angle])) * RADIANS_PER_E5DEG
    w = at.AGO_RATE
    rate = f[w] * f[w] + f[w + 1] * f[w + 1] + f[w + 2] * f[w + 2]
    return max(whole, claim * claim) + rate * f[cfg.TIME_TAG_VARIANCE]


@kernel
def lasting_variance(f, i, time, angle):
    """What is added to it for the update: the correlated part repeats itself."""
    spacing = max(seconds_between(i[ref.LAST_USED + angle], time), LEAST_SPACING)
    return (max(f[ref.ERROR_MEMORY] / spacing, ONE) - ONE) * f[ref.ERROR_VARIANCE + angle]
