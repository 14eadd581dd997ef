"""The Earth under the vehicle: WGS-84 radii, Earth rate and normal gravity, refreshed twice a second.

    R_M = a (1 − e²) / (1 − e² sin²φ)^(3/2)        R_N = a / √(1 − e² sin²φ)
    g   = g_e (1 + k sin²φ) / √(1 − e² sin²φ) · (1 − 2h/a (1 + f + m − 2f sin²φ) + 3h²/a²)

NIMA TR8350.2, third edition, eqs. 4-1 and 4-3. In float32 the radii are good to 0.5 m and gravity to 1e-6
m/s². Within 100 m/s the values change by less than 1e-5 of themselves over a refresh interval of 0.5 s.
"""

import math

import numpy as np

from firmware.nav import layout as at
from firmware.numerics.dialect import kernel
from firmware.numerics.fixed_position import radians_of_units
from firmware.numerics.trigonometry import sine_cosine

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
THREE_F = np.float32(3.0)
SEMI_MAJOR = np.float32(6378137.0)
FLATTENING = np.float32(1.0 / 298.257223563)
E2 = np.float32(0.00669437999014)
ONE_MINUS_E2 = np.float32(0.99330562000986)
EARTH_RATE = np.float32(7.292115e-5)
GRAVITY_EQUATOR = np.float32(9.7803253359)
SOMIGLIANA_K = np.float32(0.00193185265241)
GRAVITY_RATIO = np.float32(0.00344978650684)
"""m = ω² a² b / GM."""
LEAST_COS = np.float32(1.0e-3)
"""Within 6 km of a pole east-west terms are held."""


@kernel
def earth_at(s, c, h):
    """Meridian and parallel radius (R_M + h, (R_N + h) cos φ), 1/(R_M + h), 1/(R_N + h), tan φ, 1/cos φ and
    gravity at sine and cosine of the latitude and the height in m; c is at least LEAST_COS."""
    s2 = s * s
    w2 = ONE - E2 * s2
    w = np.float32(math.sqrt(w2))
    normal = SEMI_MAJOR / w
    meridian = normal * ONE_MINUS_E2 / w2 + h
    normal += h
    x = h / SEMI_MAJOR
    surface = GRAVITY_EQUATOR * (ONE + SOMIGLIANA_K * s2) / w
    gravity = surface * (
        ONE - TWO * x * (ONE + FLATTENING + GRAVITY_RATIO - TWO * FLATTENING * s2) + THREE_F * x * x
    )
    return meridian, normal * c, ONE / meridian, ONE / normal, s / c, ONE / c, gravity


@kernel
def refresh_earth(f, i):
    """Radii, Earth rate and gravity at the present position."""
    s, c = sine_cosine(radians_of_units(i[at.LATITUDE]))
    c = max(c, LEAST_COS)
    f[at.EARTH_RATE_N] = EARTH_RATE * c
    f[at.EARTH_RATE_D] = -EARTH_RATE * s
    meridian, parallel, per_meridian, per_normal, tangent, per_cos, gravity = earth_at(s, c, f[at.HEIGHT])
    f[at.MERIDIAN_RADIUS] = meridian
    f[at.PARALLEL_RADIUS] = parallel
    f[at.PER_MERIDIAN_RADIUS] = per_meridian
    f[at.PER_NORMAL_RADIUS] = per_normal
    f[at.TAN_LATITUDE] = tangent
    f[at.PER_COS_LATITUDE] = per_cos
    f[at.GRAVITY] = gravity


@kernel
def stand_on_plane(f, gravity):
    """A flat Earth at rest with the gravity that was measured: for the time before heading is known."""
    f[at.EARTH_RATE_N] = ZERO
    f[at.EARTH_RATE_D] = ZERO
    f[at.PER_MERIDIAN_RADIUS] = ZERO
    f[at.PER_NORMAL_RADIUS] = ZERO
    f[at.TAN_LATITUDE] = ZERO
    f[at.PER_COS_LATITUDE] = ONE
    f[at.GRAVITY] = gravity
