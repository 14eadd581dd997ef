"""Sentences of a two-antenna receiver (fact sheet sections 2 and 6).

Seven decimals of minutes and three of metres, angles with three, as receivers of this class print them.
What the baseline does not tell is empty: one baseline gives the heading, and pitch or roll.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from boards.chips.receivers.fields import (
    course,
    decimal,
    degrees,
    dilution,
    longitude_degrees,
    position,
    sentence,
    two_figures,
)
from boards.chips.receivers.utc import Utc
from boards.chips.world import BaselineSolution, GnssEpoch, Satellite

KNOTS = 3600.0 / 1852.0


@dataclass(frozen=True)
class Attitude:
    """What the baseline says about the body, degrees. None: not observed."""

    fixed: bool
    """Ambiguities are whole numbers."""
    heading: float
    pitch: float | None
    roll: float | None
    heading_acc: float
    tilt_acc: float
    length: float
    length_acc: float


def attitude_of(baseline: BaselineSolution | None, across: bool) -> Attitude | None:
    """`across`: the second antenna is to the right of the main one, else before it."""
    if baseline is None or baseline.fix == "NONE":
        return None
    heading = degrees(baseline.heading)
    tilt = degrees(baseline.pitch)
    return Attitude(
        fixed=baseline.fix == "FIXED",
        heading=(heading - 90.0) % 360.0 if across else heading % 360.0,
        pitch=None if across else tilt,
        roll=-tilt if across else None,
        heading_acc=degrees(baseline.heading_acc),
        tilt_acc=degrees(baseline.pitch_acc),
        length=baseline.length,
        length_acc=baseline.length_acc,
    )


@dataclass(frozen=True)
class Report:
    """One epoch as it is printed. `attitude` None: no baseline."""

    utc: Utc
    time_known: bool
    fix: bool
    epoch: GnssEpoch
    attitude: Attitude | None
    satellites: tuple[Satellite, ...]
    place_in_second: int
    """Which of the epochs of its second it is."""

    @property
    def time(self) -> bytes:
        """Time of day, empty until it is known."""
        utc = self.utc
        if not self.time_known:
            return b""
        return b"%02d%02d%02d.%02d" % (utc.hour, utc.minute, utc.second, utc.centisecond)

    @property
    def place(self) -> bytes:
        """The four fields of a position."""
        if not self.fix:
            return b",,,"
        return position(degrees(self.epoch.latitude), longitude_degrees(self.epoch.longitude), fine=True)

    @property
    def motion(self) -> tuple[float, bytes]:
        """Speed in m/s and course."""
        north, east, _ = self.epoch.velocity_ned
        return math.hypot(north, east), course(degrees(math.atan2(east, north)) % 360.0)


def _angle(value: float | None, signed: bool = True) -> bytes:
    """Three decimals; empty when it is not observed."""
    if value is None:
        return b""
    return decimal(value, 3) if signed else b"%.3f" % (round(value, 3) % 360.0)


def _date(report: Report) -> bytes:
    utc = report.utc
    return b"%02d%02d%02d" % (utc.day, utc.month, utc.year % 100) if report.time_known else b""


def gga(report: Report) -> bytes:
    """Fix data."""
    head = b"GPGGA,%b,%b" % (report.time, report.place)
    if not report.fix:
        return sentence(head + b",0,,,,M,,M,,")
    epoch = report.epoch
    used = sum(one.used for one in report.satellites)
    height = decimal(epoch.height - epoch.geoid_separation, 3)
    fields = (used, dilution(epoch.hdop), height, decimal(epoch.geoid_separation, 3))
    return sentence(head + b",1,%02d,%b,%b,M,%b,M,," % fields)


def rmc(report: Report) -> bytes:
    """Recommended minimum."""
    if not report.fix:
        return sentence(b"GPRMC,%b,V,,,,,,,%b,,,N" % (report.time, _date(report)))
    speed, over_ground = report.motion
    fields = (report.time, report.place, speed * KNOTS, over_ground, _date(report))
    return sentence(b"GPRMC,%b,A,%b,%.3f,%b,%b,,,A" % fields)


def vtg(report: Report) -> bytes:
    """Course and speed."""
    if not report.fix:
        return sentence(b"GPVTG,,T,,M,,N,,K,N")
    speed, over_ground = report.motion
    return sentence(b"GPVTG,%b,T,,M,%.3f,N,%.3f,K,A" % (over_ground, speed * KNOTS, speed * 3.6))


def zda(report: Report) -> bytes:
    """Time and date."""
    utc = report.utc
    if not report.time_known:
        return sentence(b"GPZDA,,,,,00,00")
    return sentence(b"GPZDA,%b,%02d,%02d,%04d,00,00" % (report.time, utc.day, utc.month, utc.year))


def gst(report: Report) -> bytes:
    """Error statistics."""
    if not report.fix:
        return sentence(b"GPGST,%b,,,,,,," % report.time)
    level, up = two_figures(report.epoch.h_acc * 0.5**0.5), two_figures(report.epoch.v_acc)
    return sentence(b"GPGST,%b,,,,,%b,%b,%b" % (report.time, level, level, up))


def hdt(report: Report) -> bytes:
    """True heading, of fixed ambiguities only."""
    attitude = report.attitude
    if attitude is None or not attitude.fixed:
        return sentence(b"GPHDT,,T")
    return sentence(b"GPHDT,%b,T" % _angle(attitude.heading, signed=False))


def ths(report: Report) -> bytes:
    """True heading and its status: A fixed, E real-valued ambiguities, V none."""
    attitude = report.attitude
    if attitude is None:
        return sentence(b"GPTHS,,V")
    status = b"A" if attitude.fixed else b"E"
    return sentence(b"GPTHS,%b,%b" % (_angle(attitude.heading, signed=False), status))


def pashr(report: Report) -> bytes:
    """Heading, roll and pitch with their accuracies; the quality is that of the position."""
    attitude = report.attitude
    if attitude is None or not report.fix:
        return sentence(b"PASHR,%b,,T,,,,,,,0,0" % report.time)
    tilt = _angle(attitude.tilt_acc)
    return sentence(
        b"PASHR,%b,%b,T,%b,%b,,%b,%b,%b,1,0"
        % (
            report.time,
            _angle(attitude.heading, signed=False),
            _angle(attitude.roll),
            _angle(attitude.pitch),
            b"" if attitude.roll is None else tilt,
            b"" if attitude.pitch is None else tilt,
            _angle(attitude.heading_acc),
        )
    )


def _heading_pitch_roll(attitude: Attitude | None) -> bytes:
    if attitude is None:
        return b",,"
    return b"%b,%b,%b" % (
        _angle(attitude.heading, signed=False),
        _angle(attitude.pitch),
        _angle(attitude.roll),
    )


def pashr_hpr(report: Report) -> bytes:
    """The Ashtech form: ambiguity 0 is fixed; the baseline's rms behind an empty carrier rms."""
    attitude = report.attitude
    if attitude is None:
        return sentence(b"PASHR,HPR,%b,,,,,,9,0,," % report.time)
    angles = _heading_pitch_roll(attitude)
    fields = (report.time, angles, attitude.length_acc, not attitude.fixed, dilution(report.epoch.pdop))
    return sentence(b"PASHR,HPR,%b,%b,,%.4f,%d,0,,%b" % fields)


def psat_hpr(report: Report) -> bytes:
    """The Hemisphere form; it has no gyro."""
    attitude = report.attitude if report.attitude is not None and report.attitude.fixed else None
    return sentence(b"PSAT,HPR,%b,%b,N" % (report.time, _heading_pitch_roll(attitude)))


def hpr(report: Report) -> bytes:
    """The Unicore form: quality 4 fixed, 5 real-valued ambiguities, 0 none."""
    attitude = report.attitude
    quality = 0 if attitude is None else 4 if attitude.fixed else 5
    used = sum(one.used for one in report.satellites) if report.fix else 0
    return sentence(b"GPHPR,%b,%b,%d,%02d,," % (report.time, _heading_pitch_roll(attitude), quality, used))


def avr(report: Report) -> bytes:
    """The Trimble form, with the baseline's length: quality 3 fixed, 2 real-valued ambiguities, 0 none."""
    attitude, epoch = report.attitude, report.epoch
    used = sum(one.used for one in report.satellites) if report.fix else 0
    if attitude is None:
        return sentence(b"PTNL,AVR,%b,,,,,,,,0,,%d" % (report.time, used))
    fields = (
        report.time,
        attitude.heading % 360.0,
        *_named(attitude.pitch, b"Tilt"),
        *_named(attitude.roll, b"Roll"),
        attitude.length,
        3 if attitude.fixed else 2,
        dilution(epoch.pdop),
        used,
    )
    return sentence(b"PTNL,AVR,%b,%+.4f,Yaw,%b,%b,%b,%b,%.3f,%d,%b,%d" % fields)


def _named(angle: float | None, name: bytes) -> tuple[bytes, bytes]:
    """An angle and what it is called, both empty when it is not observed."""
    return (b"", b"") if angle is None else (b"%+.4f" % angle, name)


SENTENCES: dict[str, Callable[[Report], bytes]] = {
    "GGA": gga,
    "RMC": rmc,
    "VTG": vtg,
    "ZDA": zda,
    "GST": gst,
    "HDT": hdt,
    "THS": ths,
    "PASHR": pashr,
    "PASHR,HPR": pashr_hpr,
    "PSAT,HPR": psat_hpr,
    "HPR": hpr,
    "PTNL,AVR": avr,
}
"""In order of output."""
