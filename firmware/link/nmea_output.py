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

LONGEST: Final = 82
OF_ONE_FIX: Final = 4
"""Texts kept because the sentences of one fix share them."""
MILLIKNOTS_PER_463: Final = 900
"""A knot is 463/900 m/s."""


class Validity(Enum):
    """How much the solution is worth; the value is (GGA quality, mode letter, RMC status)."""

    NONE = (0, "N", "V")
    GNSS = (1, "A", "A")
    DEAD_RECKONING = (6, "E", "A")


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


class NmeaWriter:
    """Prints sentences."""

    def __init__(self, talker: str = "IN") -> None:
        if len(talker) != 2 or not talker.isascii() or not talker.isupper():
            raise ValueError(f"NMEA talker is {talker!r}; it must be two capital letters, e.g. 'IN'")
        self._talker = talker
        self._buffer = bytearray(LONGEST)
        self._exclusive_or = entry_point(exclusive_or)
        self._bytes: NDArray[np.uint8] = np.frombuffer(self._buffer, np.uint8)

    def seal(self, body: str) -> bytes:
        """`$`, body, `*`, checksum, CR LF."""
        text = body.encode("ascii")
        count = len(text)
        self._buffer[:count] = text
        return b"$%b*%02X\r\n" % (text, self._exclusive_or(self._bytes, count))

    def gga(self, fix: OwnFix) -> bytes:
        """Position, quality and height; the height is empty while the geoid separation is not known."""
        quality = fix.validity.value[0]
        if not quality:
            return self.seal(
                f"{self._talker}GGA,{_clock(fix.time_of_day_ms)},,,,,0,{fix.satellites:02d},99.99,,,,,,"
            )
        hdop = min(fix.hdop_centi, 9999)
        altitude, separation = "", ""
        if fix.separation_mm is not None:
            altitude = _tenths(fix.height_mm - fix.separation_mm, 100)
            separation = _tenths(fix.separation_mm, 100)
        return self.seal(
            f"{self._talker}GGA,{_clock(fix.time_of_day_ms)},{_position(fix)},{quality},"
            f"{min(fix.satellites, 99):02d},{_decimal(hdop, 2)},{altitude},M,{separation},M,,"
        )

    def rmc(self, fix: OwnFix) -> bytes:
        """Position, motion and date."""
        quality, mode, status = fix.validity.value
        position = _position(fix) if quality else ",,,"
        speed = _knots(fix.speed_mmps) if quality else ""
        return self.seal(
            f"{self._talker}RMC,{_clock(fix.time_of_day_ms)},{status},{position},{speed},{_course(fix)},{_calendar(fix.date_days)},,,{mode}"
        )

    def vtg(self, fix: OwnFix) -> bytes:
        """Motion over ground."""
        quality, mode, _ = fix.validity.value
        if not quality:
            return self.seal(f"{self._talker}VTG,,T,,M,,N,,K,{mode}")
        metric = (fix.speed_mmps * 36 + 5) // 10
        return self.seal(
            f"{self._talker}VTG,{_course(fix)},T,,M,{_knots(fix.speed_mmps)},N,{_decimal(metric, 3)},K,{mode}"
        )

    def hdt(self, fix: OwnFix) -> bytes:
        """True heading."""
        heading = _decimal(fix.heading_centideg % 36000, 2) if fix.validity.value[0] else ""
        return self.seal(f"{self._talker}HDT,{heading},T")

    def pashr(self, fix: OwnFix) -> bytes:
        """Time, heading, roll, pitch and their sigmas; roll right side down, pitch nose up positive."""
        quality = fix.validity.value[0]
        if not quality:
            return self.seal(f"PASHR,{_clock(fix.time_of_day_ms)},,T,,,,,,,0,1")
        sigmas = (fix.roll_sigma_mdeg, fix.pitch_sigma_mdeg, fix.heading_sigma_mdeg)
        printed = ",".join([_decimal(min(sigma, 99999), 3) for sigma in sigmas])
        return self.seal(
            f"PASHR,{_clock(fix.time_of_day_ms)},{_decimal(fix.heading_centideg % 36000, 2)},T,"
            f"{_signed(fix.roll_centideg)},{_signed(fix.pitch_centideg)},,{printed},{quality},4"
        )


@lru_cache(OF_ONE_FIX)
def _clock(time_of_day_ms: int | None) -> str:
    if time_of_day_ms is None:
        return ""
    seconds, hundredths = divmod(time_of_day_ms // 10, 100)
    minutes, seconds = divmod(seconds, 60)
    hours, minutes = divmod(minutes, 60)
    return _decimal(hours % 24 * 1_000_000 + minutes * 10_000 + seconds * 100 + hundredths, 2, 8)


@lru_cache(OF_ONE_FIX)
def _calendar(date_days: int | None) -> str:
    """ddmmyy, by the calendar that repeats every 4 years from March on (1980 … 2099)."""
    if date_days is None:
        return ""
    # days since 1980-03-01; each cycle of four years ends with a leap day
    cycle, day = divmod(date_days - 55, 1461)
    year = min(day // 365, 3)
    day -= 365 * year
    month = (5 * day + 2) // 153
    day -= (153 * month + 2) // 5
    year += 1980 + 4 * cycle + (month >= 10)
    return f"{day + 1:02d}{(month + 2) % 12 + 1:02d}{year % 100:02d}"


@lru_cache(OF_ONE_FIX)
def _angle(nanodeg: int, digits: int) -> str:
    micro_minutes = (abs(nanodeg) * 60 + 500) // 1000
    degrees, minutes = divmod(micro_minutes, 60_000_000)
    return _decimal(degrees * 100_000_000 + minutes, 6, digits + 8)


def _position(fix: OwnFix) -> str:
    north = "N" if fix.lat_nanodeg >= 0 else "S"
    east = "E" if fix.lon_nanodeg >= 0 else "W"
    return f"{_angle(fix.lat_nanodeg, 2)},{north},{_angle(fix.lon_nanodeg, 3)},{east}"


def _knots(mmps: int) -> str:
    millis = (mmps * MILLIKNOTS_PER_463 + 231) // 463
    return _decimal(millis, 3)


def _course(fix: OwnFix) -> str:
    if fix.course_centideg is None or not fix.validity.value[0]:
        return ""
    return _decimal(fix.course_centideg % 36000, 2)


def _decimal(value: int, places: int, digits: int = 0) -> str:
    """value · 10^−places, value ≥ 0, with leading zeros up to `digits`; slicing is faster than formatting."""
    text = str(value).zfill(max(digits, places + 1))
    return f"{text[:-places]}.{text[-places:]}"


def _signed(value: int) -> str:
    return f"{'-' if value < 0 else '+'}{_decimal(abs(value), 2)}"


def _tenths(value: int, unit: int) -> str:
    """`value` in tenths of 10·`unit`, rounded; no minus sign before zero."""
    tenths = (abs(value) + unit // 2) // unit
    return f"{'-' if value < 0 and tenths else ''}{_decimal(tenths, 1)}"
