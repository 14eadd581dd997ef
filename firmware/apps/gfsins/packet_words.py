"""What the acquisition puts into a packet beside the accelerations: compass and GPS, when there is news."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from firmware.drivers import gnss_epoch as gnss
from firmware.nav.gyro_free import packet as pk

AGE_NS = 100_000
LOW = 0xFFFF
PLACES = (
    (pk.LATITUDE, 4, gnss.LAT_NANODEG),
    (pk.LONGITUDE, 4, gnss.LON_NANODEG),
    (pk.HEIGHT, 2, gnss.HEIGHT_MM),
    (pk.SPEED, 2, gnss.SPEED_MMPS),
    (pk.COURSE, 2, gnss.COURSE_E5DEG),
    (pk.TIME_OF_DAY, 2, gnss.TIME_OF_DAY_MS),
    (pk.DATE, 1, gnss.DATE_DAYS),
    (pk.QUALITY, 1, gnss.FIX_QUALITY),
    (pk.SATELLITES, 1, gnss.SATELLITES),
    (pk.HDOP, 1, gnss.HDOP_CENTI),
)
"""Of an epoch: first word, how many, place in the record."""
COURSE_FLAGS = gnss.HAS_SPEED | gnss.HAS_COURSE


def age(tick_ns: int, valid_ns: int) -> int:
    """In the packet's unit, within its word."""
    return min(max(tick_ns - valid_ns, 0) // AGE_NS, LOW)


def put_compass(words: NDArray[np.int64], reading: tuple[int, int, int, int], tick_ns: int) -> int:
    """A reading (heading, pitch, roll, its time); returns the flag for it."""
    heading, pitch, roll, valid_ns = reading
    words[pk.HEADING : pk.COMPASS_AGE + 1] = heading, pitch & LOW, roll & LOW, age(tick_ns, valid_ns)
    return pk.HAS_COMPASS


def put_epoch(words: NDArray[np.int64], epoch: Sequence[int], tick_ns: int) -> int:
    """An epoch with a position; returns the flags for it, 0 for one without."""
    told = epoch[gnss.FLAGS]
    if not told & gnss.HAS_POSITION:
        return 0
    for first, count, place in PLACES:
        value = epoch[place]
        for k in range(count):
            words[first + k] = value >> 16 * (count - 1 - k) & LOW
    words[pk.GPS_AGE] = age(tick_ns, epoch[gnss.VALID_NS])
    has_course = told & COURSE_FLAGS == COURSE_FLAGS
    return (
        pk.HAS_GPS | (pk.HAS_HEIGHT if told & gnss.HAS_HEIGHT else 0) | (pk.HAS_COURSE if has_course else 0)
    )
