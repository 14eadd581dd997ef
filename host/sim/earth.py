"""The Earth: WGS-84 ellipsoid, its rotation and Somigliana's normal gravity with height.

    g(φ, h) = g_e (1 + k sin²φ) / √(1 − e² sin²φ) · (1 − 2h/a (1 + f + m − 2f sin²φ) + 3h²/a²)

NIMA TR8350.2, third edition, eqs. 4-1 and 4-3. Gravity is taken along the ellipsoid's normal (down).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from host.sim.compiled import inner

SEMI_MAJOR = 6378137.0
FLATTENING = 1.0 / 298.257223563
E2 = FLATTENING * (2.0 - FLATTENING)
EARTH_RATE = 7.292115e-5
GRAVITY_EQUATOR = 9.7803253359
GRAVITY_POLE = 9.8321849378
SOMIGLIANA_K = (1.0 - FLATTENING) * GRAVITY_POLE / GRAVITY_EQUATOR - 1.0
GM = 3.986004418e14
_M = EARTH_RATE * EARTH_RATE * SEMI_MAJOR * SEMI_MAJOR * SEMI_MAJOR * (1.0 - FLATTENING) / GM


@inner
def radii(sin_lat: float) -> tuple[float, float]:
    """Radii of curvature in m: meridian M and prime vertical N."""
    w2 = 1.0 - E2 * sin_lat * sin_lat
    n = SEMI_MAJOR / math.sqrt(w2)
    return n * (1.0 - E2) / w2, n


@inner
def gravity(sin_lat: float, height: float) -> float:
    """Normal gravity in m/s², along down, at a height in m above the ellipsoid."""
    s2 = sin_lat * sin_lat
    surface = GRAVITY_EQUATOR * (1.0 + SOMIGLIANA_K * s2) / math.sqrt(1.0 - E2 * s2)
    x = height / SEMI_MAJOR
    return surface * (1.0 - 2.0 * x * (1.0 + FLATTENING + _M - 2.0 * FLATTENING * s2) + 3.0 * x * x)


@inner
def radii_and_gravity(sin_lat: float, height: float) -> tuple[float, float, float]:
    """M + h, N + h and gravity at once."""
    s2 = sin_lat * sin_lat
    w2 = 1.0 - E2 * s2
    by_w = 1.0 / math.sqrt(w2)
    n = SEMI_MAJOR * by_w
    x = height * (1.0 / SEMI_MAJOR)
    surface = GRAVITY_EQUATOR * (1.0 + SOMIGLIANA_K * s2) * by_w
    g = surface * (1.0 - 2.0 * x * (1.0 + FLATTENING + _M - 2.0 * FLATTENING * s2) + 3.0 * x * x)
    return n * (1.0 - E2) * by_w * by_w + height, n + height, g


def radians_per_metre(latitude: float, height: float) -> tuple[float, float]:
    """Change of latitude for a metre north and of longitude for a metre east."""
    sin_lat, cos_lat = math.sin(latitude), math.cos(latitude)
    w2 = 1.0 - E2 * sin_lat * sin_lat
    n = SEMI_MAJOR / math.sqrt(w2)
    return 1.0 / (n * (1.0 - E2) / w2 + height), 1.0 / ((n + height) * cos_lat)


def one_turn(longitude: NDArray[np.float64]) -> NDArray[np.float64]:
    """The same longitudes within ±π; those that are there already stay what they are to the last bit."""
    return longitude - 2.0 * math.pi * np.round(longitude / (2.0 * math.pi))


def geodetic_to_ecef(
    latitude: NDArray[np.float64], longitude: NDArray[np.float64], height: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Earth-centred, Earth-fixed coordinates in m, shape (n, 3)."""
    sin_lat, cos_lat = np.sin(latitude), np.cos(latitude)
    n = SEMI_MAJOR / np.sqrt(1.0 - E2 * sin_lat * sin_lat)
    return np.column_stack(
        (
            (n + height) * cos_lat * np.cos(longitude),
            (n + height) * cos_lat * np.sin(longitude),
            (n * (1.0 - E2) + height) * sin_lat,
        )
    )


def ecef_to_geodetic(
    ecef: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Latitude, longitude in rad and height in m of points (n, 3).

    Bowring's parametric latitude, three rounds: to rounding for heights within ±50 km, not at the poles.
    """
    x, y, z = ecef[:, 0], ecef[:, 1], ecef[:, 2]
    p = np.hypot(x, y)
    b = SEMI_MAJOR * (1.0 - FLATTENING)
    beta = np.arctan2(z, (1.0 - FLATTENING) * p)
    latitude = beta
    for _ in range(3):
        latitude = np.arctan2(
            z + E2 / (1.0 - E2) * b * np.sin(beta) ** 3, p - E2 * SEMI_MAJOR * np.cos(beta) ** 3
        )
        beta = np.arctan2((1.0 - FLATTENING) * np.sin(latitude), np.cos(latitude))
    sin_lat, cos_lat = np.sin(latitude), np.cos(latitude)
    n = SEMI_MAJOR / np.sqrt(1.0 - E2 * sin_lat * sin_lat)
    height = p * cos_lat + z * sin_lat - SEMI_MAJOR * SEMI_MAJOR / n
    return latitude, np.arctan2(y, x), height


def rotation_ecef_to_ned(latitude: float, longitude: float) -> NDArray[np.float64]:
    """C_n_e: v_ned = C_n_e v_ecef."""
    sp, cp = math.sin(latitude), math.cos(latitude)
    sl, cl = math.sin(longitude), math.cos(longitude)
    return np.array([[-sp * cl, -sp * sl, cp], [-sl, cl, 0.0], [-cp * cl, -cp * sl, -sp]])
