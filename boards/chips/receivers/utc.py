"""UTC from GPS time, as the receiver shows it.

GPS time runs without leap seconds since 1980-01-06 00:00; UTC = GPS time − leap seconds (fact sheet
section 3, PUBX,04; section 4, NAV-PVT). The receiver rounds the time of an epoch to the nearest hundredth
of a second and carries into minutes, hours and the date; `nano` then holds what is missing to the exact
time and may be negative (a real M8N prints second 1, nano −100 231).
"""

from datetime import date
from typing import NamedTuple

SECOND = 1_000_000_000
DAY_SECONDS = 86_400
WEEK_SECONDS = 604_800
_GPS_EPOCH_ORDINAL = date(1980, 1, 6).toordinal()
_LAST_DAY = date(9999, 12, 31).toordinal() - _GPS_EPOCH_ORDINAL
_FIRST_DAY = 1 - _GPS_EPOCH_ORDINAL


class Utc(NamedTuple):
    """A UTC instant, rounded to 0.01 s, with the exact remainder in `nano` (relative to `second`)."""

    year: int
    month: int
    day: int
    hour: int
    minute: int
    second: int
    centisecond: int
    nano: int
    days: int
    """Days since 1980-01-06."""


def utc_from_gps(gps_time_ns: int, leap_seconds: int) -> Utc:
    """UTC of a GPS time in ns. Dates outside the years 1 to 9999 stop at the border."""
    exact = gps_time_ns - leap_seconds * SECOND
    hundredths = (exact + SECOND // 200) // (SECOND // 100)
    seconds, centisecond = divmod(hundredths, 100)
    days, second_of_day = divmod(seconds, DAY_SECONDS)
    minutes, second = divmod(second_of_day, 60)
    hour, minute = divmod(minutes, 60)
    day = date.fromordinal(_GPS_EPOCH_ORDINAL + min(max(days, _FIRST_DAY), _LAST_DAY))
    nano = exact - seconds * SECOND
    return Utc(day.year, day.month, day.day, hour, minute, second, centisecond, nano, days)


def gps_week(gps_time_ns: int) -> tuple[int, int]:
    """GPS week number (not rolled over) and time of week in ms, rounded to the nearest ms."""
    milliseconds = (gps_time_ns + 500_000) // 1_000_000
    week, tow_ms = divmod(milliseconds, WEEK_SECONDS * 1000)
    return week, tow_ms
