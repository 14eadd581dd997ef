"""A plausible, deterministic sky: GPS and GLONASS satellites on circular orbits, and the geometry's DOPs.

Not an ephemeris: planes and slots are evenly spread (GPS 31 satellites in 6 planes, 26 560 km, 55°; GLONASS
24 in 3 planes, 25 510 km, 64.8°) and start from an arbitrary but fixed phase at the GPS epoch. DOPs come from
the line-of-sight vectors of the satellites used, with one receiver clock per system (Kaplan & Hegarty, 2nd
ed., section 7.3; the time DOP is that of GPS time where GPS is used).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boards.chips.world import Satellite
from host.sim.compiled import Floats, entry
from host.sim.earth import EARTH_RATE, GM, geodetic_to_ecef, rotation_ecef_to_ned
from host.sim.sine import TWO_PI, sincos

NO_DOP = 99.99
USED_ELEVATION_DEG = 10.0
ZENITH_CN0_DBHZ = 47.0
HORIZON_CN0_DBHZ = 29.0


@dataclass(frozen=True)
class Sky:
    """Satellites in view and the dilutions of precision (NO_DOP without a solution)."""

    satellites: tuple[Satellite, ...]
    pdop: float
    hdop: float
    vdop: float
    tdop: float


@dataclass(frozen=True)
class _Shell:
    system: str
    count: int
    planes: int
    radius: float
    inclination: float
    first_number: int


_SHELLS = (
    _Shell("GPS", 31, 6, 26_560e3, math.radians(55.0), 1),
    _Shell("GLONASS", 24, 3, 25_510e3, math.radians(64.8), 65),
)


def sky_at(
    gps_time_s: float, latitude: float, longitude: float, height: float, systems: list[str], mask: float
) -> Sky:
    """The open sky above a place; `mask` is the lowest elevation tracked, rad."""
    satellites: list[Satellite] = []
    here = geodetic_to_ecef(np.array([latitude]), np.array([longitude]), np.array([height]))[0]
    to_ned = rotation_ecef_to_ned(latitude, longitude)
    for shell in _SHELLS:
        if shell.system in systems:
            satellites += _in_view(shell, gps_time_s, here, to_ned, mask)
    return Sky(tuple(satellites), *dilutions(satellites))


def blocked(sky: Sky) -> Sky:
    """The same sky from inside a tunnel: satellites known but not tracked."""
    hidden = (Satellite(s.system, s.number, s.elevation, s.azimuth, 0.0, False) for s in sky.satellites)
    return Sky(tuple(hidden), NO_DOP, NO_DOP, NO_DOP, NO_DOP)


def _in_view(
    shell: _Shell, gps_time_s: float, here: NDArray[np.float64], to_ned: NDArray[np.float64], mask: float
) -> list[Satellite]:
    found = []
    sights = np.empty((shell.count, 3))
    lines_of_sight(shell.radius, shell.inclination, shell.planes, gps_time_s, here, to_ned, sights)
    for k, (north, east, down) in enumerate(sights.tolist()):
        elevation = math.atan2(-down, math.hypot(north, east))
        if elevation > mask:
            azimuth = math.atan2(east, north) % (2.0 * math.pi)
            found.append(_satellite(shell, k, elevation, azimuth, gps_time_s))
    return found


@entry
def lines_of_sight(
    radius: float,
    inclination: float,
    planes: int,
    gps_time_s: float,
    here: Floats,
    to_ned: Floats,
    out: Floats,
) -> None:
    """Vectors (n, 3) north, east, down in m from `here` (Earth-fixed) to the n satellites of a shell."""
    count = out.shape[0]
    slots = (count + planes - 1) // planes
    motion = math.sqrt(GM / (radius * radius * radius))
    tilt_sin, tilt_cos = sincos(inclination)
    for k in range(count):
        plane = k % planes
        slot = (k // planes) / slots
        along_sin, along_cos = sincos(TWO_PI * (slot + plane / (2.3 * planes)) + motion * gps_time_s)
        node_sin, node_cos = sincos(TWO_PI * plane / planes - EARTH_RATE * gps_time_s)
        level = along_sin * tilt_cos
        x = radius * (along_cos * node_cos - level * node_sin) - here[0]
        y = radius * (along_cos * node_sin + level * node_cos) - here[1]
        z = radius * along_sin * tilt_sin - here[2]
        for i in range(3):
            out[k, i] = to_ned[i, 0] * x + to_ned[i, 1] * y + to_ned[i, 2] * z


def _satellite(shell: _Shell, k: int, elevation: float, azimuth: float, gps_time_s: float) -> Satellite:
    ripple = 1.5 * math.sin(2.0 * math.pi * (gps_time_s / 170.0 + 0.37 * k)) + 1.2 * math.sin(2.4 * k)
    cn0 = HORIZON_CN0_DBHZ + (ZENITH_CN0_DBHZ - HORIZON_CN0_DBHZ) * math.sin(elevation) ** 0.6 + ripple
    used = elevation > math.radians(USED_ELEVATION_DEG)
    return Satellite(shell.system, shell.first_number + k, elevation, azimuth, cn0, used)


def dilutions(satellites: list[Satellite]) -> tuple[float, float, float, float]:
    """PDOP, HDOP, VDOP, TDOP of the satellites used; NO_DOP without a solution."""
    used = [s for s in satellites if s.used]
    systems = sorted({s.system for s in used}, reverse=True)
    if len(used) < 3 + len(systems) or not systems:
        return NO_DOP, NO_DOP, NO_DOP, NO_DOP
    rows = []
    for s in used:
        level = math.cos(s.elevation)
        sight = [level * math.cos(s.azimuth), level * math.sin(s.azimuth), -math.sin(s.elevation)]
        rows.append(sight + [1.0 if s.system == system else 0.0 for system in systems])
    design = np.array(rows)
    variance = np.diag(np.linalg.inv(design.T @ design))
    horizontal, vertical = math.sqrt(variance[0] + variance[1]), math.sqrt(variance[2])
    return math.hypot(horizontal, vertical), horizontal, vertical, math.sqrt(variance[-1])
