"""The states of the last 1.2 s, and what has been corrected since: a GNSS epoch is compared where it is
valid.

The ring holds velocity, attitude and position at least 10 ms apart. `look_up` interpolates between two of
them and adds the corrections that were made after that instant, carried back over Δt:

    δr(t) = δr − Δt δv        δv(t) = δv + (−g Δt)_n × φ        φ(t) = φ

(the velocity term for the part of ∫f that is always there; layout.LOG_F). While the attitude is not yet
known, alignment keeps other quantities in the same places and looks them up in the same way.
"""

import numpy as np

from firmware.nav import layout as at
from firmware.nav import tuning as cfg
from firmware.numerics.dialect import kernel
from firmware.numerics.fixed_position import add_to_latitude, add_to_longitude
from firmware.numerics.quaternion import normalise_quaternion, quaternion_of_rotation, quaternion_product
from firmware.numerics.wide_integers import float32_of_int64, int64_of_float32

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
HALF_TURN_UNITS = np.float32(3.0e12)
SECONDS_PER_NS = np.float32(1.0e-9)
THREE = np.int32(3)
EIGHT = np.int32(8)
SPAN = np.int64(8)
"""Entries on either side for rates of change: 0.16 s at 100 Hz, to let vibration pass."""


@kernel
def seconds_between(earlier, later):
    """later − earlier in s, for differences below three days."""
    return float32_of_int64(later - earlier) * SECONDS_PER_NS


@kernel
def clear_history(i):
    """Forget all past states and corrections."""
    i[at.RING_COUNT] = 0
    i[at.LOG_COUNT] = 0


@kernel
def remember(f, i):
    """Push the present state, unless the last one is too recent."""
    head = i[at.RING_HEAD] & at.RING_MASK
    if i[at.RING_COUNT] > 0:
        if i[at.TIME] - i[at.RING_I + 3 * head] < i[cfg.RING_SPACING_NS]:
            return
        head = (head + 1) & at.RING_MASK
    i[at.RING_HEAD] = head
    if i[at.RING_COUNT] < at.RING_SIZE:
        i[at.RING_COUNT] += 1
    whole = at.RING_I + 3 * head
    i[whole] = i[at.TIME]
    i[whole + 1] = i[at.LATITUDE]
    i[whole + 2] = i[at.LONGITUDE]
    part = at.RING_F + at.RING_FLOATS * head
    f[part] = f[at.VELOCITY]
    f[part + 1] = f[at.VELOCITY + 1]
    f[part + 2] = f[at.VELOCITY + 2]
    f[part + 3] = f[at.QUATERNION]
    f[part + 4] = f[at.QUATERNION + 1]
    f[part + 5] = f[at.QUATERNION + 2]
    f[part + 6] = f[at.QUATERNION + 3]
    f[part + 7] = f[at.HEIGHT]


@kernel
def log_correction(f, i):
    """Note the correction just fed back (layout.CORRECTION) for the states before it."""
    head = (i[at.LOG_HEAD] + 1) & at.LOG_MASK
    i[at.LOG_HEAD] = head
    if i[at.LOG_COUNT] < at.LOG_SIZE:
        i[at.LOG_COUNT] += 1
    i[at.LOG_TIME + head] = i[at.TIME]
    for k in range(np.int32(9)):
        f[at.LOG_F + 9 * head + k] = f[at.CORRECTION + k]


@kernel
def look_up(f, i, time):
    """State at board time `time` to layout.AGO (and AGO_LATITUDE …); False when the ring does not hold it."""
    count = i[at.RING_COUNT]
    head = i[at.RING_HEAD] & at.RING_MASK
    if count < 2 or time > i[at.RING_I + 3 * head] + i[cfg.RING_SPACING_NS] + i[cfg.PERIOD_NS]:
        return False
    back = np.int64(1)
    while back < count - 1 and i[at.RING_I + 3 * ((head - back) & at.RING_MASK)] > time:
        back += 1
    before = (head - back) & at.RING_MASK
    if i[at.RING_I + 3 * before] > time:
        return False
    after = (before + 1) & at.RING_MASK
    _interpolate(f, i, before, after, time)
    newer = (head - max(back - SPAN, np.int64(0))) & at.RING_MASK
    older = (head - min(back + SPAN, count - 1)) & at.RING_MASK
    _mean_acceleration(f, i, older, newer)
    _rate_at(f, i, time, before, after, back, count)
    return True


@kernel
def _interpolate(f, i, before, after, time):
    start = i[at.RING_I + 3 * before]
    span = seconds_between(start, i[at.RING_I + 3 * after])
    weight = seconds_between(start, time) / span if span > ZERO else ONE
    p = at.RING_F + at.RING_FLOATS * before
    q = at.RING_F + at.RING_FLOATS * after
    for k in range(EIGHT):
        f[at.AGO + k] = f[p + k] + weight * (f[q + k] - f[p + k])
    latitude = i[at.RING_I + 3 * before + 1]
    longitude = i[at.RING_I + 3 * before + 2]
    step = float32_of_int64(i[at.RING_I + 3 * after + 1] - latitude)
    i[at.AGO_LATITUDE] = latitude + int64_of_float32(weight * step)
    step = float32_of_int64(i[at.RING_I + 3 * after + 2] - longitude)
    if abs(step) > HALF_TURN_UNITS:
        weight = ONE  # the date line lies between: no half-way
        longitude = i[at.RING_I + 3 * after + 2]
        step = ZERO
    i[at.AGO_LONGITUDE] = longitude + int64_of_float32(weight * step)


@kernel
def _mean_acceleration(f, i, older, newer):
    """Mean acceleration (n) around the state looked up."""
    p = at.RING_F + at.RING_FLOATS * older
    q = at.RING_F + at.RING_FLOATS * newer
    span = seconds_between(i[at.RING_I + 3 * older], i[at.RING_I + 3 * newer])
    per_span = ONE / span if span > ZERO else ZERO
    for k in range(THREE):
        f[at.AGO_ACCELERATION + k] = (f[q + k] - f[p + k]) * per_span


@kernel
def _rate_at(f, i, time, before, after, back, count):
    """Rate (b) at `time`, between the means of the two intervals nearest to it: vibration must not pass away
    here, it moves the antenna."""
    start = i[at.RING_I + 3 * before]
    middle = start + ((i[at.RING_I + 3 * after] - start) >> np.int64(1))
    wx, wy, wz = _mean_rate(f, i, before, after)
    earlier = time < middle
    if (earlier and back + 1 < count) or (not earlier and back >= 2):
        other = (before - 1) & at.RING_MASK if earlier else (after + 1) & at.RING_MASK
        first = other if earlier else after
        last = before if earlier else other
        beside = i[at.RING_I + 3 * first]
        beside += (i[at.RING_I + 3 * last] - beside) >> np.int64(1)
        weight = seconds_between(middle, time) / seconds_between(middle, beside)
        vx, vy, vz = _mean_rate(f, i, first, last)
        wx += weight * (vx - wx)
        wy += weight * (vy - wy)
        wz += weight * (vz - wz)
    f[at.AGO_RATE] = wx
    f[at.AGO_RATE + 1] = wy
    f[at.AGO_RATE + 2] = wz


@kernel
def _mean_rate(f, i, first, last):
    """Mean rate (b) between two entries."""
    p = at.RING_F + at.RING_FLOATS * first
    q = at.RING_F + at.RING_FLOATS * last
    span = seconds_between(i[at.RING_I + 3 * first], i[at.RING_I + 3 * last])
    w, x, y, z = quaternion_product(
        f[p + 3], -f[p + 4], -f[p + 5], -f[p + 6], f[q + 3], f[q + 4], f[q + 5], f[q + 6]
    )
    twice = TWO / span if span > ZERO else ZERO
    twice = twice if w >= ZERO else -twice
    return twice * x, twice * y, twice * z


@kernel
def correct_past(f, i, time):
    """Add to the state looked up at `time` what has been corrected since."""
    for n in range(np.int32(at.LOG_SIZE)):
        if n >= i[at.LOG_COUNT]:
            return
        entry = (i[at.LOG_HEAD] - i[at.LOG_COUNT] + 1 + n) & at.LOG_MASK
        if i[at.LOG_TIME + entry] > time:
            _correct_by(f, i, at.LOG_F + 9 * entry, seconds_between(time, i[at.LOG_TIME + entry]))


@kernel
def _correct_by(f, i, p, dt):
    i[at.AGO_LATITUDE] = add_to_latitude(
        i[at.AGO_LATITUDE], (f[p] - dt * f[p + 3]) * f[at.PER_MERIDIAN_RADIUS]
    )
    i[at.AGO_LONGITUDE] = add_to_longitude(
        i[at.AGO_LONGITUDE],
        (f[p + 1] - dt * f[p + 4]) * f[at.PER_NORMAL_RADIUS] * f[at.PER_COS_LATITUDE],
    )
    f[at.AGO_HEIGHT] -= f[p + 2] - dt * f[p + 5]
    gdt = f[at.GRAVITY] * dt
    f[at.AGO_VELOCITY] += f[p + 3] + gdt * f[p + 7]
    f[at.AGO_VELOCITY + 1] += f[p + 4] - gdt * f[p + 6]
    f[at.AGO_VELOCITY + 2] += f[p + 5]
    aw, ax, ay, az = quaternion_of_rotation(f[p + 6], f[p + 7], f[p + 8])
    q = at.AGO_QUATERNION
    w, x, y, z = quaternion_product(aw, ax, ay, az, f[q], f[q + 1], f[q + 2], f[q + 3])
    f[q], f[q + 1], f[q + 2], f[q + 3] = normalise_quaternion(w, x, y, z)
