"""Heading by the magnetometer (`..heading`) in integers.

The variance of the heading is kept as the pace p = 1/T = P/r, which needs no other unit:

    p ← p + (1/625 + 2 σ²/(r p)) dt,     K = w p dt/(1 + w p dt),     p ← (1 − K) p

with σ² = P_bias + (0.5 % of the mean vertical rate)² in (°/s)² and r = 58 (°)² s.
"""

import numpy as np

from firmware.nav.drift import layout as flag
from firmware.nav.drift.fixed import layout as at
from firmware.nav.drift.fixed.smoothing import grown, keep, smooth
from firmware.numerics.dialect import kernel
from firmware.numerics.fixed.angles import ONE_Q30, angle_of_radians, arc_tangent2, sine_cosine, wrap
from firmware.numerics.fixed.arithmetic import in_q, product, rounded_shift
from firmware.numerics.fixed.roots import quotient, square_root

DIP_LIMIT = angle_of_radians(10.0 * 3.141592653589793 / 180.0)
TENTH = in_q(0.1, 30)
STEEPEST = in_q(0.05, 30)
STEEPEST_SQUARE = in_q(0.05, 30)
SMALLEST_PACE = in_q(1.0 / 25.0, at.Q_PACE)
LARGEST_PACE = in_q(1.0 / 5.0, at.Q_PACE)
LOST_PACE = in_q(100.0 / 58.0, at.Q_PACE)
"""A variance of (10°)²."""
STEADY_GROWTH = in_q(1.0 / 625.0, 32)
LARGEST_GROWTH = in_q(0.45, 32)
"""1/s²."""
TWICE_PER_DENSITY = in_q(2.0 / 58.0, 30)
RATE_SHARE = in_q(0.005 * 180.0 / 3.141592653589793, 30)
USUAL_VARIANCE = in_q((2.5 * 3.141592653589793 / 180.0) ** 2, 30)
RADIANS = in_q(3.141592653589793 / 2.0, 30)
"""Of a binary angle, in Q30."""
TURNING = in_q((20.0 * 3.141592653589793 / 180.0) ** 2, 30)
FINE_HEADING = 16
FINE_PACE = at.Q_FINE_PACE - at.Q_PACE


@kernel
def take_field(d, k, mx, my, mz):
    """Correct the heading by a field in the level frame, each component below 2³⁰."""
    across = mx * mx + my * my
    norm = square_root(across + mz * mz)
    across = square_root(across)
    weight = grown(k, at.FIELD_AGE, at.SETTLED + 2)
    norm = smooth(d, k, at.FIELD, 2, at.FIELD_GAIN, weight, norm)
    dip = smooth(d, k, at.FIELD + 1, 2, at.FIELD_GAIN, weight, arc_tangent2(mz, across))
    _judge(d, k, norm, dip)
    if across <= product(STEEPEST, norm, 30):
        return
    error = wrap(np.int64(d[at.DECLINATION]) - arc_tangent2(my, mx) - np.int64(d[at.HEADING]))
    _uncertain(d, k)
    paced = product(np.int64(d[at.HEADING_PACE]), np.int64(d[at.PERIOD]), at.Q_PACE + at.Q_PERIOD - 30)
    information = product(_trust(d, k, norm, dip), paced, 30)
    gain = quotient(information, ONE_Q30 + information, 30)
    k[at.FINE_PACE] -= product(gain, np.int64(d[at.HEADING_PACE]), 30 - FINE_PACE)
    _show_pace(d, k)
    if k[at.FORCE_AGE] < k[at.SETTLED] and k[at.HEADING_AGE] < k[at.SETTLED + 3]:
        k[at.HEADING_AGE] = min(k[at.HEADING_AGE], k[at.UNLEVELLED_AGE])
    averaging = grown(k, at.HEADING_AGE, at.SETTLED + 3)
    if averaging > 0:
        k[at.FLAGS] |= flag.REGAINING
    k[at.FINE_HEADING] += product(max(gain, averaging), error, 30 - FINE_HEADING)
    turned = wrap(rounded_shift(k[at.FINE_HEADING], FINE_HEADING))
    k[at.FINE_HEADING] = (turned << FINE_HEADING) + (k[at.FINE_HEADING] & ((1 << FINE_HEADING) - 1))
    keep(d, k, at.HEADING, turned)


@kernel
def _is_like(d, reference, norm, dip):
    known = np.int64(d[reference])
    return abs(norm - known) < product(TENTH, known, 30) and abs(dip - np.int64(d[reference + 1])) < DIP_LIMIT


@kernel
def _approach(d, k, reference, norm, dip):
    share = np.int64(d[at.REFERENCE_SHARE])
    keep(d, k, reference, np.int64(d[reference]) + product(share, norm - np.int64(d[reference]), 30))
    keep(
        d, k, reference + 1, np.int64(d[reference + 1]) + product(share, dip - np.int64(d[reference + 1]), 30)
    )


@kernel
def _judge(d, k, norm, dip):
    """Set FIELD_DISTURBED; learn what the undisturbed field is."""
    disturbed = True
    if _is_like(d, at.FIELD_NORM, norm, dip):
        k[at.UNDISTURBED_TIME] += 1
        if k[at.UNDISTURBED_TIME] >= k[at.BELIEVED_AFTER]:
            disturbed = False
            _approach(d, k, at.FIELD_NORM, norm, dip)
    else:
        k[at.UNDISTURBED_TIME] = 0
    if not _is_like(d, at.CANDIDATE_NORM, norm, dip):
        k[at.CANDIDATE_TIME] = 0
        keep(d, k, at.CANDIDATE_NORM, norm)
        keep(d, k, at.CANDIDATE_DIP, dip)
    else:
        if _turns(d):
            k[at.CANDIDATE_TIME] += 1
        _approach(d, k, at.CANDIDATE_NORM, norm, dip)
        needed = k[at.FIRST_AFTER] if d[at.FIELD_NORM] == 0 else k[at.NEW_AFTER]
        if disturbed and k[at.CANDIDATE_TIME] >= needed:
            if d[at.FIELD_NORM] == 0:
                k[at.REJECTED_TIME] = 0
            d[at.FIELD_NORM] = d[at.CANDIDATE_NORM]
            d[at.FIELD_DIP] = d[at.CANDIDATE_DIP]
            k[at.UNDISTURBED_TIME] = k[at.BELIEVED_AFTER]
            disturbed = False
    if disturbed:
        k[at.FLAGS] |= flag.FIELD_DISTURBED


@kernel
def _turns(d):
    low = at.REST_RATE + 3
    x = np.int64(d[low])
    y = np.int64(d[low + 1])
    z = np.int64(d[low + 2])
    return rounded_shift(x * x, 20) + rounded_shift(y * y, 20) + rounded_shift(z * z, 20) >= TURNING


@kernel
def _uncertain(d, k):
    """Let the pace grow with what may turn the heading."""
    rate = product(RATE_SHARE, np.int64(d[at.MOTION + 8 + at.MOTION_CHANNELS]), 30)  # °/s in Q25
    variance = np.int64(d[at.BIAS_VARIANCE]) + rounded_shift(rate * rate, 20)
    drift = product(TWICE_PER_DENSITY, min(variance, np.int64(ONE_Q30)), 30)
    pace = np.int64(d[at.HEADING_PACE])
    drift = quotient(drift, max(pace, np.int64(SMALLEST_PACE)), 18)  # 1/s² in Q24
    growth = min(STEADY_GROWTH + (drift << 8), np.int64(LARGEST_GROWTH))
    later = k[at.FINE_PACE] + product(growth, np.int64(d[at.PERIOD]), 32 + at.Q_PERIOD - at.Q_FINE_PACE)
    most = max(np.int64(LARGEST_PACE) << FINE_PACE, k[at.FINE_PACE])
    k[at.FINE_PACE] = min(max(later, np.int64(SMALLEST_PACE) << FINE_PACE), most)
    _show_pace(d, k)


@kernel
def _show_pace(d, k):
    keep(d, k, at.HEADING_PACE, rounded_shift(k[at.FINE_PACE], FINE_PACE))


@kernel
def _trust(d, k, norm, dip):
    """Share of the gain that the field deserves, Q30."""
    if k[at.FLAGS] & flag.FIELD_DISTURBED != 0:
        if d[at.HEADING_PACE] > LOST_PACE:
            return np.int64(ONE_Q30 >> 1)
        if k[at.REJECTED_TIME] <= k[at.LONGEST_REJECTION]:
            k[at.REJECTED_TIME] += 1
            return np.int64(0)
        return np.int64(ONE_Q30 >> 1)
    k[at.REJECTED_TIME] = max(k[at.REJECTED_TIME] - 2, np.int64(0))
    known = np.int64(d[at.FIELD_NORM])
    norm_error = quotient(norm - known, known, 30)
    dip_error = product(dip - np.int64(d[at.FIELD_DIP]), RADIANS, 30)
    _, cosine = sine_cosine(np.int64(d[at.FIELD_DIP]))
    steep = max(rounded_shift(cosine * cosine, 30), np.int64(STEEPEST_SQUARE))
    usual = product(USUAL_VARIANCE, steep, 30)
    spread = rounded_shift(norm_error * norm_error + dip_error * dip_error, 31)
    return quotient(usual, usual + spread, 30)
