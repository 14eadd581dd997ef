"""Proprietary sentences PUBX,00 03 04 (fact sheet section 3), written as real M8 receivers write them.

Accuracies have two significant figures, identifiers, elevation (signed) and C/N0 are those of public M8
logs; satellites are numbered as in UBX (SBAS 120–158, GLONASS 65–96, Galileo 211–246, BeiDou 159–163 and
33–64). Without a fix PUBX,00 shows status NF, huge accuracies and the last position (zeros before the
first one); time fields stay empty until the time is known.
"""

from __future__ import annotations

from boards.chips.neo_m8n.nmea import KILOMETRES_PER_HOUR, NmeaSet
from boards.chips.neo_m8n.solution import FIX_2D, Solution
from boards.chips.receivers.fields import course, decimal, degrees, dilution, position, two_figures
from boards.chips.receivers.utc import DAY_SECONDS, WEEK_SECONDS
from boards.chips.world import Satellite

NO_FIX_H_ACC = 5_303_302
NO_FIX_V_ACC = 3_750_001
TIME_PULSE_GRANULARITY_NS = 21
LONGEST_LOCK_S = 64


def flat_number(satellite: Satellite) -> int:
    """The one-byte satellite number of PUBX,03 and NAV-SVINFO."""
    number = satellite.number
    if satellite.system == "SBAS":
        return number + 87
    if satellite.system == "GALILEO":
        return 210 + number % 100
    if satellite.system == "BEIDOU":
        short = number % 100
        return 158 + short if short <= 5 else 27 + short
    return number


def pubx_00(printed: NmeaSet) -> bytes:
    """Position, accuracies, velocity."""
    solution = printed.solution
    epoch = solution.epoch
    style = printed.style
    where = position(solution.latitude_deg, solution.longitude_deg, style.fine)
    head = b"PUBX,00,%b,%b,%b" % (printed.time, where, decimal(solution.height, 3))
    cog = course(solution.course_deg)
    if not solution.fix:
        return b"%b,NF,%d,%d,0.000,%b,0.000,,99.99,99.99,99.99,0,0,0" % (
            head,
            NO_FIX_H_ACC,
            NO_FIX_V_ACC,
            cog,
        )
    return b"%b,%b,%b,%b,%b,%b,%b,,%b,%b,%b,%d,0,0" % (
        head,
        b"G2" if solution.fix == FIX_2D else b"G3",
        two_figures(epoch.h_acc),
        two_figures(epoch.v_acc),
        decimal(solution.speed * KILOMETRES_PER_HOUR, 3),
        cog,
        decimal(epoch.velocity_ned[2], 3),
        dilution(epoch.hdop),
        dilution(epoch.vdop),
        dilution(epoch.tdop),
        solution.used,
    )


def pubx_03(solution: Solution) -> bytes:
    """Satellites: number, status, azimuth, elevation, C/N0, lock time."""
    lock = min(solution.running_ms // 1000, LONGEST_LOCK_S)
    blocks = [b"PUBX,03,%d" % len(solution.satellites)]
    for satellite in solution.satellites:
        cn0 = min(int(satellite.cn0_dbhz + 0.5), 99)
        tracked = cn0 > 0
        status = b"U" if satellite.used and solution.fix else b"e" if tracked and solution.sky_known else b"-"
        angles = b","
        if solution.sky_known:
            azimuth = int(degrees(satellite.azimuth) % 360.0 + 0.5) % 360
            angles = b"%03d,%02d" % (azimuth, round(degrees(satellite.elevation)))
        level = b"%02d" % cn0 if tracked else b""
        blocks.append(
            b"%d,%b,%b,%b,%03d" % (flat_number(satellite), status, angles, level, lock if tracked else 0)
        )
    return b",".join(blocks)


def pubx_04(printed: NmeaSet) -> bytes:
    """Time of day, UTC time of week and week, leap seconds (D while they are the default), clock."""
    solution = printed.solution
    utc = solution.utc
    when = b",,,"
    if solution.time_known:
        second_of_day = (utc.hour * 60 + utc.minute) * 60 + utc.second
        week, second = divmod(utc.days * DAY_SECONDS + second_of_day, WEEK_SECONDS)
        when = b"%b,%b,%d.%02d,%d" % (printed.time, printed.date, second, utc.centisecond, week)
    leap = b"%d" % solution.leap_seconds if solution.leap_known else b"%dD" % solution.leap_seconds
    return b"PUBX,04,%b,%b,%d,%b,%d" % (
        when,
        leap,
        solution.clock_bias_ns,
        decimal(solution.clock_drift, 3),
        TIME_PULSE_GRANULARITY_NS,
    )
