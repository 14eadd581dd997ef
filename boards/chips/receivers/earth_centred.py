"""Position and velocity in the frame that is centred in the Earth and turns with it (WGS-84)."""

from __future__ import annotations

import math

_MAJOR_M = 6_378_137.0
_SQUARED_ECCENTRICITY = 0.00669437999014

Triple = tuple[float, float, float]


def earth_centred(
    latitude: float, longitude: float, height: float, velocity_ned: Triple
) -> tuple[Triple, Triple]:
    """x, y, z in m and m/s; from rad, m above the ellipsoid, and m/s."""
    s_lat, c_lat, s_lon, c_lon = (
        math.sin(latitude),
        math.cos(latitude),
        math.sin(longitude),
        math.cos(longitude),
    )
    normal = _MAJOR_M / math.sqrt(1.0 - _SQUARED_ECCENTRICITY * s_lat * s_lat)
    radius = (normal + height) * c_lat
    place = (radius * c_lon, radius * s_lon, (normal * (1.0 - _SQUARED_ECCENTRICITY) + height) * s_lat)
    north, east, down = velocity_ned
    level = -north * s_lat - down * c_lat
    return place, (level * c_lon - east * s_lon, level * s_lon + east * c_lon, north * c_lat - down * s_lat)
