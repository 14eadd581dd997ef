"""ATTITUDE frames, which hold integers alone, as the solutions that everybody on this side understands."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from firmware.link.frames import ATTITUDE, NO_DATE, NO_TIME_OF_DAY, SOLUTION
from firmware.nav.attitude.flags import NOTICE_NAMES
from firmware.nav.flags import FLAG_NAMES
from host.link.messages import SOLUTION_DTYPE, Solution

FIRST_FLAG = 16
"""Flags of an ATTITUDE frame stand from this bit on, behind those of a SOLUTION."""
SOLUTIONS = (SOLUTION, ATTITUDE)
"""Kinds of frames that hold a solution."""
METRES_PER_SECOND, RADIANS, METRES = 1e-6, 4e-9, 1e-6

ATTITUDE_DTYPE = np.dtype(
    [
        ("time_us", "<u8"),
        ("mode", "u1"),
        ("flags", "<u2"),
        ("age_us", "<u2"),
        ("lat_nanodeg", "<i8"),
        ("lon_nanodeg", "<i8"),
        ("height", "<i8"),
        ("velocity", "<i4", 3),
        ("angles", "<i4", 3),
        ("rates", "<i4", 3),
        ("gyro_bias", "<i4", 3),
    ]
)
"""ATTITUDE payloads one after the other, for many at once; numbers as they stand on the wire."""

ROW_DTYPE = np.dtype(
    [
        (name, "<u4" if name == "flags" else field.base.str.replace("f4", "f8"), field.shape)
        for name, (field, *_) in SOLUTION_DTYPE.fields.items()  # type: ignore[union-attr]
    ]
)
"""Of `solution_rows`."""


def solution_rows(kind: int, payloads: Sequence[bytes]) -> NDArray[np.void]:
    """Payloads of one kind of SOLUTIONS as one array: fields of SOLUTION_DTYPE, floats in 64 bits."""
    data = b"".join(payloads)
    if kind == SOLUTION:
        return np.frombuffer(data, SOLUTION_DTYPE).astype(ROW_DTYPE)
    told = np.frombuffer(data, ATTITUDE_DTYPE)
    rows = np.zeros(len(told), ROW_DTYPE)
    for name in ("time_us", "mode", "lat_nanodeg", "lon_nanodeg"):
        rows[name] = told[name]
    rows["time_of_day_ms"], rows["date_days"] = NO_TIME_OF_DAY, NO_DATE
    rows["flags"] = told["flags"].astype(np.uint32) << FIRST_FLAG
    rows["height"] = told["height"] * METRES
    rows["velocity_ned"] = told["velocity"] * METRES_PER_SECOND
    for place, name in enumerate(("yaw", "pitch", "roll")):
        rows[name] = told["angles"][:, place] * RADIANS
    rows["omega_b"] = told["rates"] * RADIANS
    for name in ("sigma_position", "sigma_velocity", "sigma_attitude"):
        rows[name] = np.nan
    return rows


def flag_name(bit: int) -> str:
    """Of a flag of a `Solution`."""
    names = FLAG_NAMES if bit < FIRST_FLAG else NOTICE_NAMES
    place = bit % FIRST_FLAG
    return names[place] if place < len(names) else f"flag_{bit}"


def attitude_as_solution(numbers: tuple[float, ...]) -> Solution:
    """The unpacked numbers of one ATTITUDE frame."""
    time_us, mode, flags, _age_us, lat, lon, height, *rest = numbers
    return Solution._make(
        (
            int(time_us),
            NO_TIME_OF_DAY,
            NO_DATE,
            int(mode),
            int(flags) << FIRST_FLAG,
            int(lat),
            int(lon),
            height * METRES,
            *(one * METRES_PER_SECOND for one in rest[:3]),
            *(one * RADIANS for one in rest[3:9]),
            *(math.nan,) * 9,
        )
    )
