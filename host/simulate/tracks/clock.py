"""UTC of a file as GPS time."""

from __future__ import annotations

from datetime import UTC, datetime

GPS_EPOCH = datetime(1980, 1, 6, tzinfo=UTC)
LEAP_SECONDS = 18
"""Since 2017; earlier files come out too late by what was fewer then."""


def gps_ns(moment: datetime) -> int:
    """GPS time since 1980-01-06 in ns."""
    elapsed = moment - GPS_EPOCH
    micros = (elapsed.days * 86400 + elapsed.seconds + LEAP_SECONDS) * 1_000_000 + elapsed.microseconds
    return micros * 1000
