"""A beginning that an operator has entered, in place of what alignment finds: place, velocity, attitude.

Keys of a profile, `begin_…`; each group whole or not at all. It holds at the power-up of the DSP; a vehicle
that moves has gone on by its velocity when navigation begins.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from firmware.nav.gyro_free.filters import DEG, Beginning

PLACE = ("begin_latitude_deg", "begin_longitude_deg", "begin_height_m")
VELOCITY = ("begin_north_mps", "begin_east_mps", "begin_down_mps")
ATTITUDE = ("begin_heading_deg", "begin_pitch_deg", "begin_roll_deg")
GROUPS = (PLACE, VELOCITY, ATTITUDE)
RANGES = {
    **dict(zip(PLACE, ((-90.0, 90.0), (-180.0, 180.0), (-1000.0, 20_000.0)), strict=True)),
    **dict.fromkeys(VELOCITY, (-500.0, 500.0)),
    **dict(zip(ATTITUDE, ((-360.0, 360.0), (-89.0, 89.0), (-180.0, 180.0)), strict=True)),
}
SEMI_MAJOR, ECCENTRICITY_SQUARE = 6378137.0, 6.69437999014e-3
SIGMA_PLACE = {"sigma_position": 1.0}
SIGMA_VELOCITY = {"sigma_velocity": 0.02}
SIGMA_ATTITUDE = {"sigma_tilt": 10.0 / 60.0 * DEG, "sigma_yaw": 20.0 / 60.0 * DEG}
"""How well a beginning that is entered is known: the document's initial errors."""
FARTHEST = 100.0
"""m from where the receiver is: what was entered is of another journey, or of before a reset."""
Three = tuple[float, float, float]


def group(profile: Mapping[str, Any], names: tuple[str, ...]) -> Three | None:
    """Three values, or None when the profile has none of them. ValueError when it has some."""
    given = [name for name in names if profile.get(name) is not None]
    if not given:
        return None
    missing = [name for name in names if name not in given]
    if missing:
        told = ", ".join(f"{name} = {profile[name]!r}" for name in given)
        raise ValueError(f"profile key {missing[0]} is missing beside {told}; they belong together")
    first, second, third = (float(profile[name]) for name in names)
    return first, second, third


def certainty(profile: Mapping[str, Any]) -> dict[str, float]:
    """1 σ of what was entered."""
    sigmas: dict[str, float] = {}
    for names, known in ((PLACE, SIGMA_PLACE), (VELOCITY, SIGMA_VELOCITY), (ATTITUDE, SIGMA_ATTITUDE)):
        if group(profile, names) is not None:
            sigmas |= known
    return sigmas


def degrees_per_metre(latitude_deg: float) -> tuple[float, float]:
    """Of latitude and longitude, on the ellipsoid."""
    sine, cosine = math.sin(math.radians(latitude_deg)), math.cos(math.radians(latitude_deg))
    square = 1.0 - ECCENTRICITY_SQUARE * sine * sine
    normal = SEMI_MAJOR / math.sqrt(square)
    meridian = normal * (1.0 - ECCENTRICITY_SQUARE) / square
    return math.degrees(1.0 / meridian), math.degrees(1.0 / (normal * max(cosine, 1e-6)))


def entered_beginning(found: Beginning, profile: Mapping[str, Any]) -> Beginning | None:
    """`found` by alignment, with what was entered instead; None: the receiver is not where that says."""
    velocity, place, angles = (group(profile, names) for names in (VELOCITY, PLACE, ATTITUDE))
    fix = found.latitude_nanodeg * 1e-9, found.longitude_nanodeg * 1e-9
    if velocity is not None:
        found = replace(found, velocity=velocity)
    if angles is not None:
        yaw, pitch, roll = map(math.radians, angles)
        found = replace(found, angles=(yaw, pitch, roll))
    if place is not None:
        north, east, down = (found.t_ns * 1e-9 * speed for speed in found.velocity)
        per_north, per_east = degrees_per_metre(place[0])
        latitude, longitude = place[0] + north * per_north, place[1] + east * per_east
        off = math.hypot((latitude - fix[0]) / per_north, (longitude - fix[1]) / per_east)
        if off > FARTHEST:
            return None
        found = replace(
            found,
            latitude_nanodeg=round(latitude * 1e9),
            longitude_nanodeg=round(longitude * 1e9),
            height=place[2] - down,
        )
    return found
