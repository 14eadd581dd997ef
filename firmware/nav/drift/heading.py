"""Heading by the magnetometer, and when not to believe it.

The field is turned into the level frame. An undisturbed one has a norm and a dip that hardly change; both are
smoothed (τ = 0.05 s) and compared with what is known of them (Laidig & Seel 2023):

* within 10 % and 10° for 0.5 s it is undisturbed, and what is known follows it (τ = 20 s);
* otherwise it is rejected, for 60 s at most; after that it counts half;
* another norm and dip that stay the same for 20 s of motion (5 s at the beginning) become the known ones.

Within those limits a disturbance still turns the heading. It has no preferred direction, so what it does to
norm and dip tells what it does to the heading, of which it turns more the steeper the field:

    σ_e² = ((Δnorm/norm)² + Δdip²)/2 / cos² dip

The variance of a measurement, r/dt, grows by 1 + σ_e²/σ_0² with σ_0 = 2.5°.

The gain is that of a Kalman filter of the heading alone. Its variance P grows with what may turn the
heading: a drift rate of variance σ² that keeps its sign for about T adds 2 σ² T a second, T = r/P being the
filter's own time constant,

    P ← P + (q + 2 σ² T) dt,     K = P / (P + r/(w dt)),     P ← (1 − K) P,      w = 1/(1 + σ_e²/σ_0²)

σ is what the bias filter says of the vertical axis, and 0.5 % of the mean rate about it, as gyros' scales
are wrong. r = 58 (°)² s, so that T is the published 9 s for a bias known to 0.2 °/s, and q so that it is
never more than 25 s; it is never less than 5 s, that of a bias known to 0.5 °/s, as at the beginning.

The first headings are averaged; as long as levelling is being averaged itself, over the last 0.3 s only.
"""

import math

import numpy as np

from firmware.nav.drift import layout as at
from firmware.nav.drift.levelling import TAU as FORCE_TAU
from firmware.nav.drift.smoothing import grown, smooth
from firmware.numerics.dialect import kernel
from firmware.numerics.trigonometry import arc_tangent2, sine_cosine

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
PI = np.float32(3.14159265358979)
TWO_PI = np.float32(6.28318530717959)

FIELD_TAU = np.float32(0.05)
REFERENCE_TAU = np.float32(20.0)
NORM_LIMIT = np.float32(0.1)
DIP_LIMIT = np.float32(10.0 * 3.141592653589793 / 180.0)
BELIEVED_AFTER = np.float32(0.5)
LONGEST_REJECTION = np.float32(60.0)
NEW_AFTER = np.float32(20.0)
FIRST_AFTER = np.float32(5.0)
NEW_NEEDS_RATE_SQUARE = np.float32((20.0 * 3.141592653589793 / 180.0) ** 2)
STEEPEST = np.float32(0.05)
"""Smallest cosine of the dip with a heading in it."""

SHORTEST_TIME = np.float32(5.0)
LONGEST_TIME = np.float32(25.0)
DENSITY = np.float32(58.0 * (3.141592653589793 / 180.0) ** 2)
DRIFT_DENSITY = np.float32(58.0 * (3.141592653589793 / 180.0) ** 2 / 625.0)
SMALLEST_VARIANCE = DENSITY / LONGEST_TIME
LARGEST_VARIANCE = DENSITY / SHORTEST_TIME
LOST_VARIANCE = np.float32((10.0 * 3.141592653589793 / 180.0) ** 2)
"""A heading so uncertain takes any field; its dip may be wrong for want of levelling."""
UNLEVELLED_AGE = np.float32(0.3)
"""As long as levelling is being averaged, headings are as wrong as it is, and are not worth keeping."""
RATE_SHARE = np.float32(0.005)
USUAL_VARIANCE = np.float32((2.5 * 3.141592653589793 / 180.0) ** 2)


@kernel
def wrap(angle):
    """An angle of (−3π, 3π] in (−π, π]."""
    if angle > PI:
        angle = angle - TWO_PI
    if angle <= -PI:
        angle = angle + TWO_PI
    return angle


@kernel
def take_field(d, k, dt, mx, my, mz, drift_variance):
    """Correct the heading by a field in the level frame; its drift rate has a variance of (rad/s)²."""
    across = mx * mx + my * my
    norm = np.float32(math.sqrt(across + mz * mz))
    across = np.float32(math.sqrt(across))
    weight = grown(d, at.FIELD_AGE, dt, FIELD_TAU)
    norm = smooth(d, at.FIELD, 2, at.FIELD_GAIN, weight, norm)
    dip = smooth(d, at.FIELD + 1, 2, at.FIELD_GAIN, weight, arc_tangent2(mz, across))
    _judge(d, k, dt, norm, dip)
    if not across > STEEPEST * norm:
        return
    error = wrap(wrap(d[at.DECLINATION] - arc_tangent2(my, mx)) - d[at.HEADING])
    _uncertain(d, dt, drift_variance)
    information = dt * _trust(d, k, dt, norm, dip) * d[at.HEADING_VARIANCE]
    gain = information / (information + DENSITY)
    d[at.HEADING_VARIANCE] = d[at.HEADING_VARIANCE] * (ONE - gain)
    if d[at.FORCE_AGE] < FORCE_TAU and d[at.HEADING_AGE] < SHORTEST_TIME:
        d[at.HEADING_AGE] = min(d[at.HEADING_AGE], UNLEVELLED_AGE)
    averaging = grown(d, at.HEADING_AGE, dt, SHORTEST_TIME)
    if averaging > ZERO:
        k[at.FLAGS] |= at.REGAINING
    d[at.HEADING] = wrap(d[at.HEADING] + min(max(gain, averaging), ONE) * error)


@kernel
def _is_like(d, reference, norm, dip):
    """Whether norm and dip are those whose index is `reference`."""
    known = d[reference]
    return abs(norm - known) < NORM_LIMIT * known and abs(dip - d[reference + 1]) < DIP_LIMIT


@kernel
def _approach(d, reference, dt, norm, dip):
    share = min(dt / (REFERENCE_TAU + HALF * dt), ONE)
    d[reference] = d[reference] + share * (norm - d[reference])
    d[reference + 1] = d[reference + 1] + share * (dip - d[reference + 1])


@kernel
def _judge(d, k, dt, norm, dip):
    """Set FIELD_DISTURBED; learn what the undisturbed field is."""
    disturbed = True
    if _is_like(d, at.FIELD_NORM, norm, dip):
        d[at.UNDISTURBED_TIME] = d[at.UNDISTURBED_TIME] + dt
        if d[at.UNDISTURBED_TIME] >= BELIEVED_AFTER:
            disturbed = False
            _approach(d, at.FIELD_NORM, dt, norm, dip)
    else:
        d[at.UNDISTURBED_TIME] = ZERO
    if not _is_like(d, at.CANDIDATE_NORM, norm, dip):
        d[at.CANDIDATE_TIME] = ZERO
        d[at.CANDIDATE_NORM] = norm
        d[at.CANDIDATE_DIP] = dip
    else:
        if _turns(d):
            d[at.CANDIDATE_TIME] = d[at.CANDIDATE_TIME] + dt
        _approach(d, at.CANDIDATE_NORM, dt, norm, dip)
        needed = FIRST_AFTER if d[at.FIELD_NORM] == ZERO else NEW_AFTER
        if disturbed and d[at.CANDIDATE_TIME] >= needed:
            if d[at.FIELD_NORM] == ZERO:
                d[at.REJECTED_TIME] = ZERO
            d[at.FIELD_NORM] = d[at.CANDIDATE_NORM]
            d[at.FIELD_DIP] = d[at.CANDIDATE_DIP]
            d[at.UNDISTURBED_TIME] = BELIEVED_AFTER
            disturbed = False
    if disturbed:
        k[at.FLAGS] |= at.FIELD_DISTURBED


@kernel
def _turns(d):
    low = at.REST_RATE + 3
    square = d[low] * d[low] + d[low + 1] * d[low + 1] + d[low + 2] * d[low + 2]
    return square >= NEW_NEEDS_RATE_SQUARE


@kernel
def _uncertain(d, dt, drift_variance):
    """Let the variance of the heading grow with what may turn it."""
    rate = RATE_SHARE * d[at.MOTION + 8 + at.MOTION_CHANNELS]
    variance = drift_variance + rate * rate
    time = min(DENSITY / d[at.HEADING_VARIANCE], LONGEST_TIME)
    now = d[at.HEADING_VARIANCE]
    later = now + (DRIFT_DENSITY + TWO * variance * time) * dt
    d[at.HEADING_VARIANCE] = min(max(later, SMALLEST_VARIANCE), max(now, LARGEST_VARIANCE))


@kernel
def _trust(d, k, dt, norm, dip):
    """Share of the gain that the field deserves."""
    if k[at.FLAGS] & at.FIELD_DISTURBED:
        if d[at.HEADING_VARIANCE] > LOST_VARIANCE:
            return HALF
        if d[at.REJECTED_TIME] <= LONGEST_REJECTION:
            d[at.REJECTED_TIME] = d[at.REJECTED_TIME] + dt
            return ZERO
        return HALF
    d[at.REJECTED_TIME] = max(d[at.REJECTED_TIME] - TWO * dt, ZERO)
    norm_error = norm / d[at.FIELD_NORM] - ONE
    dip_error = dip - d[at.FIELD_DIP]
    _, cosine = sine_cosine(d[at.FIELD_DIP])
    spread = HALF * (norm_error * norm_error + dip_error * dip_error) / max(cosine * cosine, STEEPEST)
    return USUAL_VARIANCE / (USUAL_VARIANCE + spread)
