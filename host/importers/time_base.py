"""Clocks of recordings on one axis: GPS time, ns since 1980-01-06, as int64.

GPS time runs ahead of UTC by the leap seconds since 1980 (IERS Bulletin C; 18 s since 2017-01-01). Unix time
is UTC without leap seconds. A week of GPS time has 604,800 s.
"""

from __future__ import annotations

from datetime import UTC, date, datetime

import numpy as np
from numpy.typing import NDArray

from host.record.errors import UserError

NS = 1_000_000_000
WEEK_NS = 604_800 * NS
DAY_NS = 86_400 * NS
GPS_EPOCH_UNIX_S = 315_964_800
LEAP_DATES = (
    *("1981-07-01", "1982-07-01", "1983-07-01", "1985-07-01", "1988-01-01", "1990-01-01", "1991-01-01"),
    *("1992-07-01", "1993-07-01", "1994-07-01", "1996-01-01", "1997-07-01", "1999-01-01", "2006-01-01"),
    *("2009-01-01", "2012-07-01", "2015-07-01", "2017-01-01"),
)
"""From the n-th of these dates on, GPS time is n s ahead of UTC."""

Integers = NDArray[np.int64]

_LEAPS_UNIX_NS = np.array(
    [int(datetime.fromisoformat(f"{day}T00:00:00+00:00").timestamp()) * NS for day in LEAP_DATES],
    dtype=np.int64,
)


def leap_seconds_at(unix_ns: int) -> int:
    """GPS time minus UTC at a Unix time, s."""
    return int(np.searchsorted(_LEAPS_UNIX_NS, unix_ns, side="right"))


def gps_from_unix(unix_ns: Integers, leap_seconds: int | None = None) -> Integers:
    """GPS time in ns of Unix times in ns; `leap_seconds` None: from the table."""
    leaps = np.searchsorted(_LEAPS_UNIX_NS, unix_ns, side="right") if leap_seconds is None else leap_seconds
    gps: Integers = unix_ns - GPS_EPOCH_UNIX_S * NS + np.asarray(leaps, dtype=np.int64) * NS
    return gps


def unix_from_gps(gps_ns: int, leap_seconds: int | None = None) -> int:
    """Unix time in ns of a GPS time in ns."""
    plain = gps_ns + GPS_EPOCH_UNIX_S * NS
    if leap_seconds is None:
        leap_seconds = leap_seconds_at(plain - leap_seconds_at(plain) * NS)
    return plain - leap_seconds * NS


def utc_text(gps_ns: int, leap_seconds: int | None = None) -> str:
    """Date and time of day in UTC, to the s."""
    unix_s = unix_from_gps(gps_ns, leap_seconds) // NS
    return datetime.fromtimestamp(unix_s, UTC).strftime("%Y-%m-%dT%H:%M:%SZ")


def day_of(text: str) -> date:
    """A date as given to --date. Raises UserError."""
    try:
        return date.fromisoformat(text)
    except ValueError:
        raise UserError(f"--date {text}: is not a date; for example --date 2018-09-07") from None


def unix_day(day: date) -> int:
    """Days since 1970-01-01."""
    return (day - date(1970, 1, 1)).days
