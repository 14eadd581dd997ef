"""What becomes of levelling and heading when an angle was lost (`..losing`, `..rates`) in integers.

    σ = |Δω| t/4 + α t²/12,    T' = T/√(1 + T² σ² (g/v)²),    p ← p + σ²/r

with α = 20 rad/s², v = 1 m/s, r = 58 (°)² s; σ in Q30 rad. After saturation, and when rates were missing for
long, σ is not known: levelling keeps an age of 0.3 s, and the heading is learned anew.
"""

import numpy as np

from firmware.nav.drift.fixed import layout as at
from firmware.numerics.dialect import kernel
from firmware.numerics.fixed.arithmetic import in_q, product
from firmware.numerics.fixed.roots import quotient, square_root

LARGEST_CHANGE = 1 << 30
LARGEST_LOSS = in_q(1.5, 30)
SMALLEST_LOSS = in_q(0.002, 30)
PAUSE_AFTER = in_q(0.02, 30)
HAND_ACCELERATION = in_q(20.0 / 12.0, 30)
GRAVITY_SQUARE = in_q(9.80665**2, 20)
PER_DENSITY = in_q((180.0 / 3.141592653589793) ** 2 / 58.0, 24)
"""1/s for a variance of 1 rad²."""
ONE_Q20 = 1 << 20
LOST_PACE = in_q(4.0, at.Q_PACE)


@kernel
def unknown_turn(d, k, x, y, z):
    """σ of MISSING_TIME samples between RATE and the rate (x, y, z)."""
    samples = min(k[at.MISSING_TIME], k[at.LONGEST_MISSING])
    time = product(samples, np.int64(d[at.PERIOD]), at.Q_PERIOD - 30)
    dx = _change(x, d, 0)
    dy = _change(y, d, 1)
    dz = _change(z, d, 2)
    changed = product(square_root(dx * dx + dy * dy + dz * dz), time, at.Q_RATE + 2)
    return min(changed + product(HAND_ACCELERATION, product(time, time, 30), 30), np.int64(LARGEST_LOSS))


@kernel
def _change(rate, d, axis):
    return min(abs(rate - np.int64(d[at.RATE + axis])), np.int64(LARGEST_CHANGE))


@kernel
def lose(d, k, sigma):
    """The attitude has become uncertain by sigma more."""
    if sigma <= SMALLEST_LOSS:
        return
    square = product(sigma, sigma, 30)
    age = product(k[at.FORCE_AGE], np.int64(d[at.PERIOD]), at.Q_PERIOD - 20)
    grown = product(product(product(age, age, 20), square, 30), GRAVITY_SQUARE, 20)
    root = square_root((ONE_Q20 + grown) << 20)
    k[at.FORCE_AGE] = max(quotient(k[at.FORCE_AGE], root, 20), np.int64(1))
    most = np.int64(PER_DENSITY) << (at.Q_FINE_PACE - 24)
    pace = k[at.FINE_PACE] + product(square, PER_DENSITY, 30 + 24 - at.Q_FINE_PACE)
    k[at.FINE_PACE] = max(k[at.FINE_PACE], min(pace, most))
    if sigma > PAUSE_AFTER:
        k[at.BIAS_PAUSE] = k[at.PAUSE]
    k[at.LOSSES] += 1


@kernel
def lose_all(k):
    """An unknown angle was lost."""
    if k[at.SAMPLES] > 0:
        k[at.FORCE_AGE] = min(k[at.FORCE_AGE], k[at.YOUNG])
        k[at.FINE_PACE] = max(k[at.FINE_PACE], np.int64(LOST_PACE) << (at.Q_FINE_PACE - at.Q_PACE))
        k[at.BIAS_PAUSE] = k[at.PAUSE]
        k[at.LOSSES] += 1
