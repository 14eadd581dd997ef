"""UBX satellite lists: NAV-SVINFO (01 30) and NAV-SAT (01 35).

Pseudorange residuals are not modelled and are zero; orbits are always "ephemeris" once the sky is known.
"""

from __future__ import annotations

from struct import Struct

from boards.chips.neo_m8n.pubx import flat_number
from boards.chips.neo_m8n.solution import Solution
from boards.chips.neo_m8n.ubx import CLASS_NAV, frame
from boards.chips.receivers.fields import degrees
from boards.chips.world import Satellite

_SVINFO_HEAD = Struct("<IBBH")
_SVINFO_BLOCK = Struct("<4BBbhi")
_SAT_HEAD = Struct("<IBBH")
_SAT_BLOCK = Struct("<BBBbhhI")

CHIP_GENERATION_M8 = 4
GNSS_ID = {"GPS": 0, "SBAS": 1, "GALILEO": 2, "BEIDOU": 3, "GLONASS": 6}
UNKNOWN_ELEVATION = -91
QUALITY_LOCKED = 7
QUALITY_IDLE = 0


def gnss_number(satellite: Satellite) -> int:
    """The satellite number within its system, as UBX counts."""
    if satellite.system == "SBAS":
        return satellite.number + 87
    if satellite.system == "GLONASS":
        return satellite.number - 64
    if satellite.system in ("GALILEO", "BEIDOU"):
        return satellite.number % 100
    return satellite.number


def _angles(satellite: Satellite, sky_known: bool) -> tuple[int, int]:
    if not sky_known:
        return UNKNOWN_ELEVATION, 0
    return round(degrees(satellite.elevation)), round(degrees(satellite.azimuth)) % 360


def nav_svinfo(solution: Solution) -> bytes:
    """01 30: one block of 12 bytes for each channel."""
    satellites = solution.satellites[:255]
    blocks = [_SVINFO_HEAD.pack(solution.tow_ms, len(satellites), CHIP_GENERATION_M8, 0)]
    for channel, satellite in enumerate(satellites):
        cn0 = min(int(satellite.cn0_dbhz + 0.5), 255)
        used = bool(solution.fix and satellite.used)
        flags = (0x01 if used else 0) | (0x0C if solution.sky_known else 0)
        quality = QUALITY_LOCKED if cn0 else QUALITY_IDLE
        elevation, azimuth = _angles(satellite, solution.sky_known)
        blocks.append(
            _SVINFO_BLOCK.pack(channel, flat_number(satellite), flags, quality, cn0, elevation, azimuth, 0)
        )
    return frame(CLASS_NAV, 0x30, b"".join(blocks))


def nav_sat(solution: Solution) -> bytes:
    """01 35: one block of 12 bytes for each satellite."""
    satellites = solution.satellites[:255]
    blocks = [_SAT_HEAD.pack(solution.tow_ms, 1, len(satellites), 0)]
    for satellite in satellites:
        cn0 = min(int(satellite.cn0_dbhz + 0.5), 255)
        used = bool(solution.fix and satellite.used)
        quality = QUALITY_LOCKED if cn0 else QUALITY_IDLE
        orbit = 0x1900 if solution.sky_known else 0
        flags = quality | (0x08 if used else 0) | 0x10 | orbit
        elevation, azimuth = _angles(satellite, solution.sky_known)
        blocks.append(
            _SAT_BLOCK.pack(
                *(GNSS_ID[satellite.system], gnss_number(satellite), cn0, elevation, azimuth, 0, flags)
            )
        )
    return frame(CLASS_NAV, 0x35, b"".join(blocks))
