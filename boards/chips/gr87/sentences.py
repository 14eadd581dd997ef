"""The sentences of a SiRF III in the precision of fact sheet section 5: talker GP, NMEA 2.2.

Time hhmmss.sss, minutes with four decimals, speed and course with two, dilutions and altitude with one, GGA
with station 0000, RMC without mode and magnetic variation. Without a fix positions, altitude and dilutions
are empty; time and date are those of the receiver's own clock.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from boards.chips.receivers.fields import degrees, longitude_degrees, sentence
from boards.chips.receivers.utc import Utc
from boards.chips.world import GnssEpoch, Satellite

KNOTS = 3600.0 / 1852.0
UNITS = 600_000
"""1e-4 minutes in a degree."""
CHANNELS = 12
"""Satellites that GSA and GSV show."""


@dataclass(frozen=True)
class Picture:
    """What the receiver shows of one epoch."""

    utc: Utc
    epoch: GnssEpoch
    fix: int
    """GSA's figure: 1 none, 2 two-dimensional, 3 three-dimensional."""
    course_deg: float
    satellites: tuple[Satellite, ...]
    """In view, GPS alone."""
    gps_ns: int
    """GPS time by its own clock."""

    @property
    def used(self) -> list[Satellite]:
        """In the solution."""
        return [one for one in self.satellites if one.used][:CHANNELS] if self.fix > 1 else []


def _time(picture: Picture) -> bytes:
    utc = picture.utc
    return b"%02d%02d%02d.%02d0" % (utc.hour, utc.minute, utc.second, utc.centisecond)


def _date(picture: Picture) -> bytes:
    utc = picture.utc
    return b"%02d%02d%02d" % (utc.day, utc.month, utc.year % 100)


def _angle(value_deg: float, digits: int, limit_deg: int) -> bytes:
    units = min(int(abs(value_deg) * UNITS + 0.5), limit_deg * UNITS)
    whole, rest = divmod(units, UNITS)
    return b"%0*d%02d.%04d" % (digits, whole, *divmod(rest, 10_000))


def _position(picture: Picture) -> bytes:
    if picture.fix < 2:
        return b",,,"
    latitude, longitude = degrees(picture.epoch.latitude), longitude_degrees(picture.epoch.longitude)
    return b"%b,%b,%b,%b" % (
        _angle(latitude, 2, 90),
        b"S" if latitude < 0.0 else b"N",
        _angle(longitude, 3, 180),
        b"W" if longitude < 0.0 else b"E",
    )


def _speed(picture: Picture) -> float:
    north, east, _ = picture.epoch.velocity_ned
    return math.hypot(north, east)


def _course(picture: Picture) -> bytes:
    return b"%.2f" % (round(picture.course_deg, 2) % 360.0)


def _one(value: float) -> bytes:
    """One decimal, no −0.0."""
    return b"%.1f" % (round(value, 1) + 0.0)


def gga(picture: Picture) -> list[bytes]:
    """Fix data."""
    epoch, used = picture.epoch, len(picture.used)
    head = b"GPGGA,%b,%b" % (_time(picture), _position(picture))
    if picture.fix < 2:
        return [sentence(head + b",0,00,,,M,0.0,M,,0000")]
    altitude = _one(epoch.height - epoch.geoid_separation)
    rest = (used, _one(min(epoch.hdop, 50.0)), altitude, _one(epoch.geoid_separation))
    return [sentence(head + b",1,%02d,%b,%b,M,%b,M,,0000" % rest)]


def gll(picture: Picture) -> list[bytes]:
    """Position."""
    status = b"A" if picture.fix > 1 else b"V"
    return [sentence(b"GPGLL,%b,%b,%b" % (_position(picture), _time(picture), status))]


def gsa(picture: Picture) -> list[bytes]:
    """Satellites used and dilutions."""
    numbers = [b"%02d" % one.number for one in picture.used]
    slots = b",".join(numbers + [b""] * (CHANNELS - len(numbers)))
    if picture.fix < 2:
        return [sentence(b"GPGSA,A,1,%b,,," % slots)]
    epoch = picture.epoch
    dilutions = b",".join(_one(min(value, 50.0)) for value in (epoch.pdop, epoch.hdop, epoch.vdop))
    return [sentence(b"GPGSA,A,%d,%b,%b" % (picture.fix, slots, dilutions))]


def gsv(picture: Picture) -> list[bytes]:
    """Satellites in view, four a sentence."""
    shown = picture.satellites[:CHANNELS]
    count = max(1, -(-len(shown) // 4))
    lines = []
    for number in range(count):
        blocks = b"".join(_block(one) for one in shown[4 * number : 4 * number + 4])
        lines.append(sentence(b"GPGSV,%d,%d,%02d%b" % (count, number + 1, len(shown), blocks)))
    return lines


def _block(satellite: Satellite) -> bytes:
    elevation = min(90, max(0, round(degrees(satellite.elevation))))
    azimuth = round(degrees(satellite.azimuth)) % 360
    level = b"%02d" % min(99, round(satellite.cn0_dbhz)) if satellite.cn0_dbhz > 0.0 else b""
    return b",%02d,%02d,%03d,%b" % (satellite.number, elevation, azimuth, level)


def rmc(picture: Picture) -> list[bytes]:
    """Recommended minimum."""
    status, motion = b"V", b","
    if picture.fix > 1:
        status, motion = b"A", b"%.2f,%b" % (_speed(picture) * KNOTS, _course(picture))
    fields = (_time(picture), status, _position(picture), motion, _date(picture))
    return [sentence(b"GPRMC,%b,%b,%b,%b,%b,," % fields)]


def vtg(picture: Picture) -> list[bytes]:
    """Course and speed."""
    if picture.fix < 2:
        return [sentence(b"GPVTG,,T,,M,,N,,K")]
    speed = _speed(picture)
    return [sentence(b"GPVTG,%b,T,,M,%.2f,N,%.1f,K" % (_course(picture), speed * KNOTS, speed * 3.6))]


def zda(picture: Picture) -> list[bytes]:
    """Time and date."""
    utc = picture.utc
    fields = (_time(picture), utc.day, utc.month, utc.year)
    return [sentence(b"GPZDA,%b,%02d,%02d,%04d,00,00" % fields)]


SENTENCES: dict[int, Callable[[Picture], list[bytes]]] = {
    0: gga, 1: gll, 2: gsa, 3: gsv, 4: rmc, 5: vtg, 8: zda
}  # fmt: skip
"""By the number that $PSRF103 has for them, in order of output; 6 would be MSS, of a beacon receiver."""
