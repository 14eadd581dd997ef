"""The Earth under the aircraft in fixed point: WGS-84 curvature, Earth rate and normal gravity.

The formulas of `firmware.nav.earth`, arranged so that what is divided by lies near 1:

    1/(R_M + h) = k/(1 + h k), k = w³/(a (1 − e²))      1/(R_N + h) likewise, k = w/a      w = √(1 − e² sin²φ)
"""

import numpy as np

from firmware.nav.attitude import flags as fl
from firmware.nav.attitude.fixed import layout as at
from firmware.nav.attitude.fixed.samples import store
from firmware.numerics.dialect import kernel
from firmware.numerics.fixed.angles import ONE_Q30, sine_cosine
from firmware.numerics.fixed.arithmetic import in_q, product, saturated
from firmware.numerics.fixed.roots import quotient, square_root

SEMI_MAJOR = 6378137.0
E2 = 0.00669437999014
FLATTENING = 1.0 / 298.257223563
GRAVITY_RATIO = 0.00344978650684

E2_Q37 = in_q(E2, 37)
PER_PRIME = in_q(1.0 / SEMI_MAJOR, 53)
PER_MERIDIAN = in_q(1.0 / (SEMI_MAJOR * (1.0 - E2)), 53)
EARTH_RATE = in_q(7.292115e-5, at.Q_EARTH_RATE)
SOMIGLIANA_K = in_q(0.00193185265241, 39)
GRAVITY_EQUATOR = in_q(9.7803253359, at.Q_INCREMENT)
ONE_F_M = in_q(1.0 + FLATTENING + GRAVITY_RATIO, 30)
TWO_F = in_q(2.0 * FLATTENING, 37)
LEAST_COS = in_q(1.0e-3, 30)
BINARY_PER_UNIT = in_q(2.0 / (2.0 * np.pi), 30)
"""Binary angle for 512 units of 2⁻⁴⁰ rad."""


@kernel
def per_radius(curvature, height):
    """k/(1 + h k) in Q53, with h in 2⁻¹² m."""
    return quotient(curvature, ONE_Q30 + product(height, curvature, 35), 30)


@kernel
def gravity_at(square, w, height):
    """Normal gravity in Q27, with sin²φ and √(1 − e² sin²φ) in Q30."""
    surface = GRAVITY_EQUATOR + product(GRAVITY_EQUATOR, product(square, SOMIGLIANA_K, 39), 30)
    surface = quotient(surface, w, 30)
    x = product(height, PER_PRIME, 35)
    lower = product(x, ONE_F_M - product(square, TWO_F, 37), 29)
    return product(surface, ONE_Q30 - lower + 3 * product(x, x, 30), 30)


@kernel
def refresh_earth(s, i):
    """Earth rate, curvature and gravity at the present position."""
    sine, cosine = sine_cosine(product(i[at.LATITUDE] >> 9, BINARY_PER_UNIT, 30))
    cosine = max(cosine, np.int64(LEAST_COS))
    square = product(sine, sine, 30)
    inside = ONE_Q30 - product(square, E2_Q37, 37)
    w = square_root(inside << 30)
    height = min(max(i[at.HEIGHT] >> 8, np.int64(-(1 << 29))), np.int64(1 << 29))
    kind = fl.SATURATED_EARTH
    store(s, i, at.EARTH_RATE_N, kind, product(cosine, EARTH_RATE, 30))
    store(s, i, at.EARTH_RATE_D, kind, -product(sine, EARTH_RATE, 30))
    curvature = product(product(inside, w, 30), PER_MERIDIAN, 30)
    store(s, i, at.PER_MERIDIAN_RADIUS, kind, per_radius(curvature, height))
    store(s, i, at.PER_NORMAL_RADIUS, kind, per_radius(product(w, PER_PRIME, 30), height))
    store(s, i, at.TAN_LATITUDE, kind, quotient(sine, cosine, at.Q_TANGENT))
    store(s, i, at.PER_COS_LATITUDE, kind, quotient(np.int64(ONE_Q30), cosine, at.Q_TANGENT))
    store(s, i, at.GRAVITY, kind, gravity_at(square, w, height))


@kernel
def rate_of_n(s, i):
    """ω_in^n north, east, down in Q42: the Earth's rate and that of moving over it."""
    counter = at.SATURATIONS + fl.SATURATED_EARTH
    en_n = product(np.int64(s[at.VELOCITY + 1]), np.int64(s[at.PER_NORMAL_RADIUS]), 32)
    en_e = -product(np.int64(s[at.VELOCITY]), np.int64(s[at.PER_MERIDIAN_RADIUS]), 32)
    en_d = -product(en_n, np.int64(s[at.TAN_LATITUDE]), at.Q_TANGENT)
    return (
        saturated(np.int64(s[at.EARTH_RATE_N]) + en_n, i, counter),
        saturated(en_e, i, counter),
        saturated(np.int64(s[at.EARTH_RATE_D]) + en_d, i, counter),
    )
