"""UBX navigation messages (fact sheet section 4; layouts beyond NAV-PVT as public definitions have them).

Without a fix the position fields hold the last position (zeros before the first one) with accuracies at
their largest value, and velocities are zero, as real M8 receivers do. N and E dilution are not in the
world's epoch: the horizontal one is shared equally.
"""

from __future__ import annotations

import math
from struct import Struct

from boards.chips.neo_m8n.solution import UNKNOWN_ACCURACY, Solution
from boards.chips.neo_m8n.ubx import CLASS_NAV, frame
from boards.chips.receivers.earth_centred import Triple, earth_centred

_ECEF = Struct("<I3iI")
_POSLLH = Struct("<I4i2I")
_STATUS = Struct("<I4B2I")
_DOP = Struct("<I7H")
_SOL = Struct("<IihBB3iI3iIHBBI")
_PVT = Struct("<IH5BBIiBBBB4iII3iiiIIHHIihH")
_VELNED = Struct("<I3iIIiII")
_TIMEGPS = Struct("<IihbBI")
_TIMEUTC = Struct("<IIiH5BB")
_CLOCK = Struct("<IiiII")
_TIMELS = Struct("<IB3xBbBbiHH3xB")

LOWEST, HIGHEST = -(1 << 31), (1 << 31) - 1
NO_FIX_DOP = 9999
NO_FIX_S_ACC_MMPS = 20_000
LARGEST_HEADING_ACC = 18_000_000
USNO = 3
"""UTC standard: the one derived from GPS."""
LEAP_BY_DEFAULT, LEAP_FROM_GLONASS, LEAP_FROM_GPS = 0, 1, 2


def _integer(value: float, scale: float) -> int:
    """A signed 32-bit field."""
    scaled = value * scale
    if LOWEST <= scaled <= HIGHEST:
        return round(scaled)
    return LOWEST if scaled < 0.0 else HIGHEST


def _week(solution: Solution) -> int:
    """The week in a signed 16-bit field."""
    return min(max(solution.week, -0x8000), 0x7FFF)


def _accuracy(value: float, scale: float) -> int:
    """An unsigned 32-bit accuracy."""
    scaled = value * scale
    if 0.0 <= scaled <= UNKNOWN_ACCURACY:
        return round(scaled)
    return 0 if scaled < 0.0 else UNKNOWN_ACCURACY


def _dop(value: float) -> int:
    return round(min(value * 100.0, NO_FIX_DOP))


def _position(solution: Solution) -> tuple[int, int, int, int, int, int]:
    """Longitude, latitude 1e-7°, height, mean sea level mm, accuracies mm."""
    fix = solution.fix
    return (
        _integer(solution.longitude_deg, 1e7),
        _integer(solution.latitude_deg, 1e7),
        _integer(solution.height, 1e3),
        _integer(solution.height - solution.separation, 1e3),
        _accuracy(solution.epoch.h_acc, 1e3) if fix else UNKNOWN_ACCURACY,
        _accuracy(solution.epoch.v_acc, 1e3) if fix else UNKNOWN_ACCURACY,
    )


def _heading_accuracy(solution: Solution) -> int:
    """1 σ of the course, 1e-5°: speed accuracy over speed."""
    s_acc, speed = solution.epoch.s_acc, solution.speed
    if not solution.fix or s_acc >= math.pi * speed:
        return LARGEST_HEADING_ACC
    return _accuracy(math.degrees(s_acc / speed), 1e5)


def _heading(solution: Solution) -> int:
    return round(solution.course_deg * 1e5) % 36_000_000


def _velocity(solution: Solution, scale: float) -> tuple[int, int, int]:
    if not solution.fix:
        return 0, 0, 0
    north, east, down = solution.epoch.velocity_ned
    return _integer(north, scale), _integer(east, scale), _integer(down, scale)


def _fix_flags(solution: Solution) -> int:
    """gpsFixOk, week set, time of week set."""
    return (1 if solution.fix else 0) | (0x0C if solution.time_known else 0)


def _place_accuracy(solution: Solution) -> int:
    """Of an earth-centred position, cm."""
    epoch = solution.epoch
    return _accuracy(math.hypot(epoch.h_acc, epoch.v_acc), 1e2) if solution.fix else UNKNOWN_ACCURACY


def _speed_accuracy(solution: Solution) -> int:
    """Of an earth-centred velocity, cm/s."""
    return _accuracy(solution.epoch.s_acc, 1e2) if solution.fix else NO_FIX_S_ACC_MMPS // 10


def nav_posecef(solution: Solution) -> bytes:
    """01 01: earth-centred position in cm."""
    place, _ = _earth_centred(solution)
    units = (_integer(metres, 1e2) for metres in place)
    return frame(CLASS_NAV, 0x01, _ECEF.pack(solution.tow_ms, *units, _place_accuracy(solution)))


def nav_velecef(solution: Solution) -> bytes:
    """01 11: earth-centred velocity in cm/s."""
    _, velocity = _earth_centred(solution)
    units = (_integer(speed, 1e2) for speed in velocity)
    return frame(CLASS_NAV, 0x11, _ECEF.pack(solution.tow_ms, *units, _speed_accuracy(solution)))


def nav_eoe(solution: Solution) -> bytes:
    """01 61: the last message of an epoch."""
    return frame(CLASS_NAV, 0x61, solution.tow_ms.to_bytes(4, "little"))


def nav_posllh(solution: Solution) -> bytes:
    """01 02: geodetic position."""
    return frame(CLASS_NAV, 0x02, _POSLLH.pack(solution.tow_ms, *_position(solution)))


def nav_status(solution: Solution) -> bytes:
    """01 03: fix status, time to first fix."""
    payload = _STATUS.pack(
        *(solution.tow_ms, solution.fix, _fix_flags(solution), 0, 0),
        *(solution.time_to_first_fix_ms & 0xFFFFFFFF, solution.running_ms & 0xFFFFFFFF),
    )
    return frame(CLASS_NAV, 0x03, payload)


def nav_dop(solution: Solution) -> bytes:
    """01 04: dilutions of precision."""
    if not solution.fix:
        return frame(CLASS_NAV, 0x04, _DOP.pack(solution.tow_ms, *(NO_FIX_DOP,) * 7))
    epoch = solution.epoch
    level = _dop(epoch.hdop * 0.5**0.5)
    geometric = _dop(math.hypot(epoch.pdop, epoch.tdop))
    dops = (geometric, _dop(epoch.pdop), _dop(epoch.tdop), _dop(epoch.vdop), _dop(epoch.hdop), level, level)
    return frame(CLASS_NAV, 0x04, _DOP.pack(solution.tow_ms, *dops))


def nav_sol(solution: Solution) -> bytes:
    """01 06: earth-centred position and velocity in cm and cm/s."""
    fix, epoch = solution.fix, solution.epoch
    place, velocity = _earth_centred(solution)
    payload = _SOL.pack(
        *(solution.tow_ms, _remainder_ns(solution), _week(solution)),
        *(fix, _fix_flags(solution)),
        *(_integer(metres, 1e2) for metres in place),
        _place_accuracy(solution),
        *(_integer(speed, 1e2) for speed in velocity),
        _speed_accuracy(solution),
        *(_dop(epoch.pdop) if fix else NO_FIX_DOP, 0, min(solution.used, 255), 0),
    )
    return frame(CLASS_NAV, 0x06, payload)


def nav_pvt(solution: Solution) -> bytes:
    """01 07: everything of an epoch in one message."""
    utc, fix, epoch = solution.utc, solution.fix, solution.epoch
    valid = (0x07 if solution.leap_known else 0x03) if solution.time_known else 0
    payload = _PVT.pack(
        *(solution.tow_ms, utc.year, utc.month, utc.day, utc.hour, utc.minute, utc.second, valid),
        *(solution.time_accuracy_ns, utc.nano, fix, 1 if fix else 0, 0, min(solution.used, 255)),
        *_position(solution),
        *_velocity(solution, 1e3),
        _integer(solution.speed, 1e3),
        _heading(solution),
        _accuracy(epoch.s_acc, 1e3) if fix else NO_FIX_S_ACC_MMPS,
        _heading_accuracy(solution),
        *(_dop(epoch.pdop) if fix else NO_FIX_DOP, 0, 0, 0, 0, 0),
    )
    return frame(CLASS_NAV, 0x07, payload)


def nav_velned(solution: Solution) -> bytes:
    """01 12: velocity in cm/s."""
    fix = solution.fix
    payload = _VELNED.pack(
        solution.tow_ms,
        *_velocity(solution, 1e2),
        _accuracy(math.hypot(*solution.epoch.velocity_ned), 1e2) if fix else 0,
        _accuracy(solution.speed, 1e2),
        _heading(solution),
        _accuracy(solution.epoch.s_acc, 1e2) if fix else NO_FIX_S_ACC_MMPS // 10,
        _heading_accuracy(solution),
    )
    return frame(CLASS_NAV, 0x12, payload)


def nav_timegps(solution: Solution) -> bytes:
    """01 20: GPS time."""
    valid = (0x07 if solution.leap_known else 0x03) if solution.time_known else 0
    payload = _TIMEGPS.pack(
        *(solution.tow_ms, _remainder_ns(solution), _week(solution), solution.leap_seconds),
        *(valid, solution.time_accuracy_ns),
    )
    return frame(CLASS_NAV, 0x20, payload)


def nav_timeutc(solution: Solution) -> bytes:
    """01 21: UTC."""
    utc = solution.utc
    valid = ((0x07 | USNO << 4) if solution.leap_known else 0x03) if solution.time_known else 0
    payload = _TIMEUTC.pack(
        *(solution.tow_ms, solution.time_accuracy_ns, utc.nano),
        *(utc.year, utc.month, utc.day, utc.hour, utc.minute, utc.second, valid),
    )
    return frame(CLASS_NAV, 0x21, payload)


def nav_clock(solution: Solution) -> bytes:
    """01 22: receiver clock."""
    payload = _CLOCK.pack(
        *(solution.tow_ms, solution.clock_bias_ns, round(solution.clock_drift)),
        *(solution.time_accuracy_ns, 1000 if solution.fix else UNKNOWN_ACCURACY),
    )
    return frame(CLASS_NAV, 0x22, payload)


def nav_timels(solution: Solution) -> bytes:
    """01 26: leap seconds, and where they are from; the next change is never known."""
    source = LEAP_BY_DEFAULT
    if solution.leap_known:
        glonass = any(one.used and one.system == "GLONASS" for one in solution.satellites)
        source = LEAP_FROM_GLONASS if glonass else LEAP_FROM_GPS
    valid = 1 if solution.leap_known else 0
    payload = _TIMELS.pack(solution.tow_ms, 0, source, solution.leap_seconds, 0, 0, 0, 0, 0, valid)
    return frame(CLASS_NAV, 0x26, payload)


def _remainder_ns(solution: Solution) -> int:
    """What the time of week in ms misses, −500 000 … 500 000 ns."""
    return (solution.gps_time_ns + 500_000) % 1_000_000 - 500_000


def _earth_centred(solution: Solution) -> tuple[Triple, Triple]:
    """Position m and velocity m/s in the earth-centred frame; zeros before the first position."""
    if not solution.position_known:
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    latitude, longitude = math.radians(solution.latitude_deg), math.radians(solution.longitude_deg)
    place, velocity = earth_centred(latitude, longitude, solution.height, solution.epoch.velocity_ned)
    return place, velocity if solution.fix else (0.0, 0.0, 0.0)
