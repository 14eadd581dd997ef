"""The solution as integers for NMEA: what a sentence prints and when it prints nothing."""

from __future__ import annotations

import math
from collections.abc import Sequence

from firmware.link.frames import NO_DATE, NO_TIME_OF_DAY
from firmware.link.nmea_output import OwnFix, Validity
from firmware.nav import flags as fl
from firmware.nav import solution as record

MILLI_DEGREES = 180_000.0 / math.pi
CENTI_DEGREES = 18_000.0 / math.pi
SLOWEST_COURSE = 1.0
"""m/s; below it the direction of travel is noise."""


def own_fix(
    floats: Sequence[float],
    integers: Sequence[int],
    utc: tuple[int, int],
    separation_mm: int | None,
    satellites: int,
    hdop_centi: int,
) -> OwnFix:
    """`floats`, `integers`: a solution record of `firmware.nav.solution`; `utc`: (time of day ms, date).

    Numbers that are none (a broken state that nobody has noticed yet) make a fix that is not valid.
    """
    mode, flags = integers[record.MODE], integers[record.FLAGS]
    validity = Validity.NONE
    if not all(map(math.isfinite, floats)):
        floats = [0.0] * len(floats)
    elif mode in (fl.NAVIGATING, fl.DEGRADED):
        lost = flags >> fl.GNSS_LOST & 1
        validity = Validity.DEAD_RECKONING if lost else Validity.GNSS
    north, east = floats[record.VELOCITY], floats[record.VELOCITY + 1]
    speed = math.hypot(north, east)
    course = round(math.atan2(east, north) * CENTI_DEGREES) % 36_000 if speed >= SLOWEST_COURSE else None
    sigmas = [
        round(sigma * MILLI_DEGREES) for sigma in floats[record.SIGMA_ATTITUDE : record.SIGMA_ATTITUDE + 3]
    ]
    return OwnFix(
        validity=validity,
        time_of_day_ms=None if utc[0] == NO_TIME_OF_DAY else utc[0],
        date_days=None if utc[1] == NO_DATE else utc[1],
        lat_nanodeg=integers[record.LAT_NANODEG],
        lon_nanodeg=integers[record.LON_NANODEG],
        height_mm=round(floats[record.HEIGHT] * 1000.0),
        separation_mm=separation_mm,
        speed_mmps=round(speed * 1000.0),
        course_centideg=course,
        heading_centideg=round(floats[record.YAW] * CENTI_DEGREES) % 36_000,
        roll_centideg=round(floats[record.ROLL] * CENTI_DEGREES),
        pitch_centideg=round(floats[record.PITCH] * CENTI_DEGREES),
        roll_sigma_mdeg=sigmas[0],
        pitch_sigma_mdeg=sigmas[1],
        heading_sigma_mdeg=sigmas[2],
        satellites=satellites,
        hdop_centi=hdop_centi,
    )
