"""What a SiRF III says in its binary protocol: messages 2, 4, 6, 11, 12 and 41 of SiRF's public manual.

All numbers high byte first. Without a fix 2 and 41 say so in their mode and hold zeros for the rest.
"""

from __future__ import annotations

import math
from struct import Struct

from boards.chips.gr87.binary import HEAD, TAIL
from boards.chips.gr87.sentences import Picture
from boards.chips.receivers.earth_centred import earth_centred
from boards.chips.receivers.fields import degrees, longitude_degrees
from boards.chips.receivers.utc import gps_week

NAVIGATION, TRACKER, VERSION, ACCEPTED, REFUSED, GEODETIC = 2, 4, 6, 11, 12, 41
SOFTWARE = b"GSW3.2.4"
CHANNELS = 12
MODES = {1: 0, 2: 3, 3: 4}
"""By GSA's figure: no solution, three satellites, four and more."""
WGS_84 = 21
USED, TRACKED = 0x00BF, 0x003F
"""State of a channel: all locked, with ephemeris or without."""

_NAVIGATION = Struct(">B3i3hBBBHIB12B")
_TRACKER = Struct(">BHIB")
_CHANNEL = Struct(">BBBH10B")
_GEODETIC = Struct(">BHHHIHBBBBHIiiiiBHHhhhIIIHiIiIIHHBBB")


def framed(payload: bytes) -> bytes:
    """A payload with head, length, sum and tail."""
    check = (sum(payload) & 0x7FFF).to_bytes(2, "big")
    return HEAD + len(payload).to_bytes(2, "big") + payload + check + TAIL


def answer(accepted: bool, message: int) -> bytes:
    """Of a command."""
    return framed(bytes((ACCEPTED if accepted else REFUSED, message)))


def version() -> bytes:
    """Message 6."""
    return framed(bytes((VERSION,)) + SOFTWARE + b"\0")


def navigation(picture: Picture) -> bytes:
    """Message 2: position and velocity in ECEF."""
    epoch, used = picture.epoch, [one.number for one in picture.used]
    position = velocity = (0.0, 0.0, 0.0)
    if picture.fix > 1:
        place = (epoch.latitude, epoch.longitude, epoch.height)
        position, velocity = earth_centred(*place, epoch.velocity_ned)
    week, tow_ms = gps_week(picture.gps_ns)
    return framed(
        _NAVIGATION.pack(
            NAVIGATION,
            *(round(metres) for metres in position),
            *(_limited(speed * 8.0, 15) for speed in velocity),
            MODES[picture.fix],
            min(255, round(epoch.hdop * 5.0)) if picture.fix > 1 else 250,
            0,
            week % 1024,
            tow_ms // 10,
            len(used),
            *used,
            *(0,) * (CHANNELS - len(used)),
        )
    )


def tracker(picture: Picture) -> bytes:
    """Message 4: satellites, azimuth in 1.5°, elevation in 0.5°, ten levels in dBHz."""
    week, tow_ms = gps_week(picture.gps_ns)
    shown = picture.satellites[:CHANNELS]
    blocks = []
    for one in shown:
        level = min(99, round(one.cn0_dbhz))
        state = (USED if one.used and picture.fix > 1 else TRACKED) if level else 0
        azimuth, elevation = degrees(one.azimuth) % 360.0, max(0.0, degrees(one.elevation))
        azimuth_units = int(azimuth / 1.5 + 0.5) % 240
        blocks.append(_CHANNEL.pack(one.number, azimuth_units, round(elevation * 2.0), state, *(level,) * 10))
    empty = bytes(_CHANNEL.size) * (CHANNELS - len(shown))
    return framed(_TRACKER.pack(TRACKER, week % 1024, tow_ms // 10, CHANNELS) + b"".join(blocks) + empty)


def geodetic(picture: Picture) -> bytes:
    """Message 41: latitude, longitude, heights, motion, accuracies."""
    epoch, utc, fixed = picture.epoch, picture.utc, picture.fix > 1
    north, east, down = epoch.velocity_ned if fixed else (0.0, 0.0, 0.0)
    week, tow_ms = gps_week(picture.gps_ns)
    used = picture.used
    place = (degrees(epoch.latitude), longitude_degrees(epoch.longitude)) if fixed else (0.0, 0.0)
    heights = (epoch.height, epoch.height - epoch.geoid_separation) if fixed else (0.0, 0.0)
    accuracies = (epoch.h_acc, epoch.v_acc, 0.0) if fixed else (0.0, 0.0, 0.0)
    return framed(
        _GEODETIC.pack(
            GEODETIC,
            0 if fixed else 1,
            MODES[picture.fix],
            week,
            tow_ms,
            *(utc.year, utc.month, utc.day, utc.hour, utc.minute, utc.second * 1000 + utc.centisecond * 10),
            sum({1 << one.number - 1 for one in used if 1 <= one.number <= 32}),
            *(round(angle * 1e7) for angle in place),
            *(round(height * 100.0) for height in heights),
            WGS_84,
            min(0xFFFF, round(math.hypot(north, east) * 100.0)),
            round(picture.course_deg * 100.0) % 36_000,
            0,
            _limited(-down * 100.0, 15),
            0,
            *(min(0xFFFF_FFFF, round(metres * 100.0)) for metres in accuracies),
            min(0xFFFF, round(epoch.s_acc * 100.0)) if fixed else 0,
            *(0,) * 7,
            len(used),
            min(255, round(epoch.hdop * 5.0)) if fixed else 250,
            0,
        )
    )


MESSAGES = {NAVIGATION: navigation, TRACKER: tracker, GEODETIC: geodetic}
"""What it says once a second, in order of output."""


def _limited(value: float, bits: int) -> int:
    return max(-(1 << bits), min((1 << bits) - 1, round(value)))
