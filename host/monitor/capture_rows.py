"""Rows of a capture's JSON topics as messages of the link, where there is no raw traffic of the board.

Rows are of `host.record.tables`; a value that is null or missing is NaN. The time of day is not in them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from firmware.drivers import gnss_epoch as epoch
from firmware.link import frames
from firmware.nav.flags import NAVIGATING
from host.link.messages import Bias, Gnss, Innovation, Message, Solution
from host.record.tables import INNOVATION, SLOW_STATES

NANO = 1e9
KNOWN = frozenset({"/solution", "/gnss", "/innovation", "/bias", "/event"})


def message_of(topic: str, time_ns: int, row: Mapping[str, Any]) -> tuple[int, Message] | None:
    """(kind, message); None for a topic or row that says nothing to the view."""
    time_us = time_ns // 1000
    if topic == "/solution":
        return _solution(time_us, row)
    if topic == "/gnss":
        return _gnss(time_us, row)
    if topic == "/innovation":
        columns = INNOVATION.columns[1:13]
        used = _value(row, "used")
        mask = int(used) & 0x3F if math.isfinite(used) else 0
        return frames.INNOVATION, Innovation((time_us, mask, *(_value(row, name) for name in columns)))
    if topic == "/bias":
        values = [_to_si(name, _value(row, name)) for name in SLOW_STATES]
        sigmas = [_to_si(name, _value(row, f"sigma_{name}")) for name in SLOW_STATES]
        return frames.BIAS, Bias((time_us, *values, *sigmas))
    if topic == "/event":
        return frames.TEXT, f"{row.get('source', '?')}: {row.get('text', '')}"
    return None


def _value(row: Mapping[str, Any], name: str) -> float:
    value = row.get(name)
    return float(value) if isinstance(value, int | float) else math.nan


def _to_si(name: str, value: float) -> float:
    return math.radians(value) if name.endswith(("_deg", "_dps")) else value


def _nanodeg(row: Mapping[str, Any], name: str) -> int | None:
    value = _value(row, name)
    return round(value * NANO) if math.isfinite(value) and abs(value) <= 360.0 else None


def _solution(time_us: int, row: Mapping[str, Any]) -> tuple[int, Message] | None:
    lat, lon = _nanodeg(row, "latitude_deg"), _nanodeg(row, "longitude_deg")
    if lat is None or lon is None:
        return None
    mode, flags = _value(row, "mode"), _value(row, "flags")
    names = ("height_m", "v_north_mps", "v_east_mps", "v_down_mps")
    angles = ("yaw_deg", "pitch_deg", "roll_deg")
    sigmas = [f"sigma_{axis}_m" for axis in ("north", "east", "down")]
    sigmas += [f"sigma_v_{axis}_mps" for axis in ("north", "east", "down")]
    tilts = [f"sigma_psi_{axis}_deg" for axis in "ned"]
    return frames.SOLUTION, Solution._make(
        (
            time_us,
            frames.NO_TIME_OF_DAY,
            frames.NO_DATE,
            int(mode) & 0xFF if math.isfinite(mode) else NAVIGATING,
            int(flags) & 0xFFFF if math.isfinite(flags) else 0,
            lat,
            lon,
            *(_value(row, name) for name in names),
            *(math.radians(_value(row, name)) for name in angles),
            *(math.nan,) * 3,
            *(_value(row, name) for name in sigmas),
            *(math.radians(_value(row, name)) for name in tilts),
        )
    )


def _gnss(time_us: int, row: Mapping[str, Any]) -> tuple[int, Message]:
    lat, lon = _nanodeg(row, "latitude_deg"), _nanodeg(row, "longitude_deg")
    height = _value(row, "height_m")
    velocity = [_value(row, name) for name in ("v_north_mps", "v_east_mps", "v_down_mps")]
    flags = 0
    if row.get("fix") and lat is not None and lon is not None:
        flags |= epoch.HAS_POSITION
        flags |= epoch.HAS_HEIGHT if math.isfinite(height) else 0
    north, east, down = (round(v * 1000) if math.isfinite(v) else 0 for v in velocity)
    if all(map(math.isfinite, velocity[:2])):
        flags |= epoch.HAS_SPEED
    speed = round(math.hypot(north, east))
    height_mm = round(height * 1000) if math.isfinite(height) else 0
    return frames.GNSS, Gnss(
        time_us,
        frames.NO_TIME_OF_DAY,
        frames.NO_DATE,
        flags,
        lat or 0,
        lon or 0,
        height_mm,
        0,
        speed,
        0,
        north,
        east,
        down,
        0,
        0,
        0,
        0,
    )
