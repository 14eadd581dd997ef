"""NMEA 0183 sentences of the board's own solution: GGA, RMC, VTG, HDT, PASHR (layouts: receiver fact sheet
sections 2 and 6), talker IN (integrated navigation).

Everything is formatted from integers, so that nothing is ever printed as 60.000000 minutes or −0.0. Minutes
have six decimals (1.9 mm); no sentence exceeds 82 characters.

    quality 1, mode A    navigating with GNSS
    quality 6, mode E    navigating, GNSS lost: dead reckoning
    quality 0, mode N    not navigating: positions and motion are empty
"""

from __future__ import annotations

from enum import Enum
from functools import lru_cache
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from firmware.link.nmea_checksum import exclusive_or
from firmware.numerics.dialect import entry_point
from hal.machine_code import mypyc_attr

LONGEST: Final = 82
OF_ONE_FIX: Final = 4
"""Texts kept because the sentences of one fix share them."""
MINUTE: Final = 1_000_000
DEGREE: Final = 60 * MINUTE
"""In millionths of a minute."""
NORTH, SOUTH, EAST, WEST, PLUS, MINUS = b"NSEW+-"
MILLIKNOTS_PER_463: Final = 900
"""A knot is 463/900 m/s."""


class Validity(Enum):
    """How much the solution is worth; the value is (GGA quality, mode letter, RMC status)."""

    NONE = (0, b"N", b"V")
    GNSS = (1, b"A", b"A")
    DEAD_RECKONING = (6, b"E", b"A")


class OwnFix(NamedTuple):
    """The solution in integers; None: not known, printed as an empty field."""

    validity: Validity
    time_of_day_ms: int | None
    date_days: int | None
    """Days since 1980-01-06."""
    lat_nanodeg: int
    lon_nanodeg: int
    height_mm: int
    """Above the ellipsoid."""
    separation_mm: int | None
    """Geoid above the ellipsoid."""
    speed_mmps: int
    course_centideg: int | None
    """None when too slow to have one."""
    heading_centideg: int
    roll_centideg: int
    pitch_centideg: int
    roll_sigma_mdeg: int
    pitch_sigma_mdeg: int
    heading_sigma_mdeg: int
    satellites: int
    hdop_centi: int


@mypyc_attr(allow_interpreted_subclasses=True)
class NmeaWriter:
    """Prints sentences."""

    def __init__(self, talker: str = "IN") -> None:
        if len(talker) != 2 or not talker.isascii() or not talker.isupper():
            raise ValueError(f"NMEA talker is {talker!r}; it must be two capital letters, e.g. 'IN'")
        self._talker = talker.encode("ascii")
        self._buffer = bytearray(LONGEST)
        self._exclusive_or = entry_point(exclusive_or)
        self._bytes: NDArray[np.uint8] = np.frombuffer(self._buffer, np.uint8)

    def seal(self, body: str | bytes) -> bytes:
        """`$`, body, `*`, checksum, CR LF."""
        text = body.encode("ascii") if isinstance(body, str) else body
        count = len(text)
        self._buffer[:count] = text
        return b"$%b*%02X\r\n" % (text, self._exclusive_or(self._bytes, count))

    def gga(self, fix: OwnFix) -> bytes:
        """Position, quality and height; the height is empty while the geoid separation is not known."""
        quality = fix.validity.value[0]
        clock = _clock(fix.time_of_day_ms)
        if not quality:
            return self.seal(b"%bGGA,%b,,,,,0,%02d,99.99,,,,,," % (self._talker, clock, fix.satellites))
        hdop = min(fix.hdop_centi, 9999)
        altitude = separation = b""
        if fix.separation_mm is not None:
            altitude = _tenths(fix.height_mm - fix.separation_mm, 100)
            separation = _tenths(fix.separation_mm, 100)
        return self.seal(
            b"%bGGA,%b,%b,%d,%02d,%d.%02d,%b,M,%b,M,,"
            % (
                self._talker,
                clock,
                _position(fix.lat_nanodeg, fix.lon_nanodeg),
                quality,
                min(fix.satellites, 99),
                hdop // 100,
                hdop % 100,
                altitude,
                separation,
            )
        )

    def rmc(self, fix: OwnFix) -> bytes:
        """Position, motion and date."""
        quality, mode, status = fix.validity.value
        position = _position(fix.lat_nanodeg, fix.lon_nanodeg) if quality else b",,,"
        speed = _thousandths(_milliknots(fix.speed_mmps)) if quality else b""
        return self.seal(
            b"%bRMC,%b,%b,%b,%b,%b,%b,,,%b"
            % (
                self._talker,
                _clock(fix.time_of_day_ms),
                status,
                position,
                speed,
                _course(fix),
                _calendar(fix.date_days),
                mode,
            )
        )

    def vtg(self, fix: OwnFix) -> bytes:
        """Motion over ground."""
        quality, mode, _ = fix.validity.value
        if not quality:
            return self.seal(b"%bVTG,,T,,M,,N,,K,%b" % (self._talker, mode))
        knots = _thousandths(_milliknots(fix.speed_mmps))
        metric = _thousandths((fix.speed_mmps * 36 + 5) // 10)
        return self.seal(b"%bVTG,%b,T,,M,%b,N,%b,K,%b" % (self._talker, _course(fix), knots, metric, mode))

    def hdt(self, fix: OwnFix) -> bytes:
        """True heading."""
        heading = _hundredths(fix.heading_centideg % 36000) if fix.validity.value[0] else b""
        return self.seal(b"%bHDT,%b,T" % (self._talker, heading))

    def pashr(self, fix: OwnFix) -> bytes:
        """Time, heading, roll, pitch and their sigmas; roll right side down, pitch nose up positive."""
        quality = fix.validity.value[0]
        clock = _clock(fix.time_of_day_ms)
        if not quality:
            return self.seal(b"PASHR,%b,,T,,,,,,,0,1" % clock)
        heading, roll, pitch = fix.heading_centideg % 36000, abs(fix.roll_centideg), abs(fix.pitch_centideg)
        return self.seal(
            b"PASHR,%b,%d.%02d,T,%c%d.%02d,%c%d.%02d,,%b,%b,%b,%d,4"
            % (
                clock,
                heading // 100,
                heading % 100,
                _sign(fix.roll_centideg),
                roll // 100,
                roll % 100,
                _sign(fix.pitch_centideg),
                pitch // 100,
                pitch % 100,
                _thousandths(min(fix.roll_sigma_mdeg, 99999)),
                _thousandths(min(fix.pitch_sigma_mdeg, 99999)),
                _thousandths(min(fix.heading_sigma_mdeg, 99999)),
                quality,
            )
        )


@lru_cache(OF_ONE_FIX)
def _clock(time_of_day_ms: int | None) -> bytes:
    if time_of_day_ms is None:
        return b""
    minutes, hundredths = divmod(time_of_day_ms // 10, 6000)
    return b"%02d%02d%02d.%02d" % (
        minutes // 60 % 24,
        minutes % 60,
        hundredths // 100,
        hundredths % 100,
    )


@lru_cache(OF_ONE_FIX)
def _calendar(date_days: int | None) -> bytes:
    """ddmmyy, by the calendar that repeats every 4 years from March on (1980 … 2099)."""
    if date_days is None:
        return b""
    # days since 1980-03-01; each cycle of four years ends with a leap day
    cycle, day = divmod(date_days - 55, 1461)
    year = min(day // 365, 3)
    day -= 365 * year
    month = (5 * day + 2) // 153
    day -= (153 * month + 2) // 5
    year += 1980 + 4 * cycle + (month >= 10)
    return b"%02d%02d%02d" % (day + 1, (month + 2) % 12 + 1, year % 100)


@lru_cache(OF_ONE_FIX)
def _position(lat_nanodeg: int, lon_nanodeg: int) -> bytes:
    latitude, longitude = _micro_minutes(lat_nanodeg), _micro_minutes(lon_nanodeg)
    return b"%02d%02d.%06d,%c,%03d%02d.%06d,%c" % (
        latitude // DEGREE,
        latitude // MINUTE % 60,
        latitude % MINUTE,
        NORTH if lat_nanodeg >= 0 else SOUTH,
        longitude // DEGREE,
        longitude // MINUTE % 60,
        longitude % MINUTE,
        EAST if lon_nanodeg >= 0 else WEST,
    )


def _micro_minutes(nanodeg: int) -> int:
    return (abs(nanodeg) * 60 + 500) // 1000


def _milliknots(mmps: int) -> int:
    return (mmps * MILLIKNOTS_PER_463 + 231) // 463


def _course(fix: OwnFix) -> bytes:
    if fix.course_centideg is None or not fix.validity.value[0]:
        return b""
    return _hundredths(fix.course_centideg % 36000)


def _hundredths(value: int) -> bytes:
    return b"%d.%02d" % (value // 100, value % 100)


def _thousandths(value: int) -> bytes:
    return b"%d.%03d" % (value // 1000, value % 1000)


def _sign(value: int) -> int:
    return MINUS if value < 0 else PLUS


def _tenths(value: int, unit: int) -> bytes:
    """`value` in tenths of 10·`unit`, rounded; no minus sign before zero."""
    tenths = (abs(value) + unit // 2) // unit
    return b"%b%d.%d" % (b"-" if value < 0 and tenths else b"", tenths // 10, tenths % 10)
