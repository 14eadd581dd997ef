"""From measured rates to the turn since the last sample, over gaps and saturation.

A rate stands for the interval that ends with it. Where rates are missing for a time t, the mean of the rates
on both sides stands for it; what the motion may have done in between is unknown to

    σ(t) = |Δω| t/4 + α t²/12,      α = 20 rad/s², a hand's angular acceleration.

Saturation cuts the top off a peak. With the slopes s₁, s₂ at which the axis left its range and came back a
time T later, the top is a cubic with those slopes at its ends, of the area (s₁ − s₂) T²/12, which is turned
about that axis afterwards. Of that area 30 % is unknown. Peaks of more than 0.4 s are no cubics: all is lost.
"""

import math

import numpy as np

from firmware.nav.drift import layout as at
from firmware.nav.drift.losing import lose
from firmware.numerics.dialect import kernel

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
HALF = np.float32(0.5)
QUARTER = np.float32(0.25)
TWELFTH = np.float32(1.0 / 12.0)
LARGEST_RATE = np.float32(200.0)
HAND_ACCELERATION = np.float32(20.0)
LARGEST_LOSS = np.float32(1.5)
LONGEST_PEAK = np.float32(0.4)
UNKNOWN_SHARE = np.float32(0.3)
LARGEST_SLOPE = np.float32(1000.0)


@kernel
def is_usable(x, y, z, limit):
    """Whether three numbers are numbers, within a limit that no sensor reaches."""
    return abs(x) <= limit and abs(y) <= limit and abs(z) <= limit


@kernel
def unknown_turn(x, y, z, t):
    """σ(t) for a change of rate (x, y, z)."""
    change = np.float32(math.sqrt(x * x + y * y + z * z))
    return min(QUARTER * change * t + TWELFTH * HAND_ACCELERATION * t * t, LARGEST_LOSS)


@kernel
def take_rate(d, k, dt, gap, x, y, z):
    """Take a measured rate as RATE, at most at the end of the range, or hold the last one when it is none.

    Returns what has to be turned (rad, body axes) besides RATE · dt to make up for what was missed.
    """
    if not is_usable(x, y, z, LARGEST_RATE):
        k[at.BAD_RATES] += 1
        k[at.FLAGS] |= at.NO_RATE
        d[at.MISSING_TIME] = d[at.MISSING_TIME] + dt
        if d[at.MISSING_TIME] > LONGEST_PEAK:
            lose(d, k, LARGEST_LOSS)
        return ZERO, ZERO, ZERO
    extra_x = ZERO
    extra_y = ZERO
    extra_z = ZERO
    missing = d[at.MISSING_TIME] + (dt if gap else ZERO)
    if missing > ZERO and k[at.SAMPLES] > 0:
        # The last rate (or, over a gap, this one) is held for that time; one held for long tells nothing.
        back = -HALF * missing if gap else HALF * missing
        if not gap and missing > LONGEST_PEAK:
            back = ZERO
        dx = x - d[at.RATE]
        dy = y - d[at.RATE + 1]
        dz = z - d[at.RATE + 2]
        extra_x = back * dx
        extra_y = back * dy
        extra_z = back * dz
        lose(d, k, unknown_turn(dx, dy, dz, missing))
    d[at.MISSING_TIME] = ZERO
    extra_x = extra_x + _bridged(d, k, 0, dt, x)
    extra_y = extra_y + _bridged(d, k, 1, dt, y)
    extra_z = extra_z + _bridged(d, k, 2, dt, z)
    d[at.RATE] = _within_range(d, x)
    d[at.RATE + 1] = _within_range(d, y)
    d[at.RATE + 2] = _within_range(d, z)
    return extra_x, extra_y, extra_z


@kernel
def _within_range(d, rate):
    """What a part tells beyond its range is not specified: the end of the range instead."""
    limit = d[at.RATE_LIMIT]
    return rate if limit == ZERO else min(max(rate, -limit), limit)


@kernel
def _bridged(d, k, axis, dt, rate):
    """Follow one axis through saturation. Returns the turn to be added for a peak that has ended."""
    limit = d[at.RATE_LIMIT]
    if limit == ZERO:
        return ZERO
    before = d[at.RATE + axis]
    if abs(rate) >= limit:
        k[at.SATURATED_SAMPLES] += 1
        k[at.FLAGS] |= at.SATURATED
        if d[at.CLIPPED_TIME + axis] == ZERO:
            d[at.ENTRY_SLOPE + axis] = d[at.SLOPE + axis]
            d[at.ENTRY_RATE + axis] = before
        d[at.CLIPPED_TIME + axis] = d[at.CLIPPED_TIME + axis] + dt
        k[at.LEAVING + axis] = 0
        if d[at.CLIPPED_TIME + axis] > LONGEST_PEAK:
            lose(d, k, LARGEST_LOSS)
        return ZERO
    d[at.SLOPE + axis] = (rate - before) / dt
    if d[at.CLIPPED_TIME + axis] == ZERO:
        return ZERO
    if k[at.LEAVING + axis] == 0:
        k[at.LEAVING + axis] = 1
        return ZERO
    top = _top(d, axis, dt, before)
    d[at.CLIPPED_TIME + axis] = ZERO
    k[at.LEAVING + axis] = 0
    lose(d, k, min(UNKNOWN_SHARE * abs(top), LARGEST_LOSS))
    return top


@kernel
def _top(d, axis, dt, first_after):
    """Area of the peak that was cut off, rad; the rate came back to `first_after`."""
    time = d[at.CLIPPED_TIME + axis]
    if time > LONGEST_PEAK:
        return ZERO
    limit = np.float32(math.copysign(d[at.RATE_LIMIT], first_after))
    sign = np.float32(math.copysign(ONE, first_after))
    rise = min(max(sign * d[at.ENTRY_SLOPE + axis], ZERO), LARGEST_SLOPE)
    fall = min(max(-sign * d[at.SLOPE + axis], ZERO), LARGEST_SLOPE)
    early = _part(sign * (limit - d[at.ENTRY_RATE + axis]), rise, dt)
    late = _part(sign * (limit - first_after), fall, dt)
    width = max(time + dt - early - late, ZERO)
    return sign * (rise + fall) * width * width * TWELFTH


@kernel
def _part(way, slope, dt):
    """Time in which a slope goes a way, within 0 … dt."""
    if not slope * dt > way:
        return dt
    return max(way / slope, ZERO)
