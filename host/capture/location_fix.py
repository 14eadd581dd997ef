"""Positions in the schema that Foxglove's map knows: foxglove.LocationFix, as JSON.

Times are virtual time since the start of the run; the covariance is diagonal, east, north, up in m².
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from host.record.run_data import NAVIGATING
from host.record.tables import GNSS, SOLUTION

LOCATION_FIX = "foxglove.LocationFix"
TOPICS = {"/solution": "/fix/solution", "/gnss": "/fix/gnss"}
"""Where the positions of a table go."""
EACH_S = 1.0
"""At most one in so long."""
UNKNOWN, DIAGONAL = 0, 2
FIX = (
    b'{"timestamp":{"sec":%d,"nsec":%d},"frame_id":"board","latitude":%.9f,"longitude":%.9f,"altitude":%.3f,'
    b'"position_covariance":[%.4g,0,0,0,%.4g,0,0,0,%.4g],"position_covariance_type":%d}'
)

_PLACE = ("latitude_deg", "longitude_deg", "height_m")
_SIGMAS = ("sigma_east_m", "sigma_north_m", "sigma_down_m")
_SOLUTION = [SOLUTION.columns.index(name) for name in ("mode", *_PLACE, *_SIGMAS)]
_GNSS = [GNSS.columns.index(name) for name in ("fix", *_PLACE)]

_NUMBER = {"type": "number"}
_TIME = {
    "type": "object",
    "title": "time",
    "properties": {
        "sec": {"type": "integer", "minimum": 0},
        "nsec": {"type": "integer", "minimum": 0, "maximum": 999_999_999},
    },
}


def schema() -> bytes:
    """The JSON schema: the fields that the well-known one demands; it knows a few more."""
    properties = {
        "timestamp": _TIME,
        "frame_id": {"type": "string"},
        "latitude": _NUMBER,
        "longitude": _NUMBER,
        "altitude": _NUMBER,
        "position_covariance": {"type": "array", "items": _NUMBER, "minItems": 9, "maxItems": 9},
        "position_covariance_type": {"title": "foxglove.PositionCovarianceType", "enum": [0, 1, 2, 3]},
    }
    document = {
        "title": LOCATION_FIX,
        "type": "object",
        "properties": properties,
        "required": list(properties),
    }
    return json.dumps(document, separators=(",", ":")).encode()


class Fixes:
    """Thins the rows of one table and puts them into words."""

    def __init__(self, columns: Sequence[int], least: int) -> None:
        """`columns`: state, latitude, longitude, height, and sigmas where there are any; rows with a state
        below `least` have no position."""
        self._columns = list(columns)
        self._least = least
        self._slot = -1.0

    @classmethod
    def of(cls, topic: str) -> Fixes:
        """Of a run's table."""
        return cls(_SOLUTION, NAVIGATING) if topic == "/solution" else cls(_GNSS, 1)

    @classmethod
    def of_columns(cls, names: Sequence[str]) -> Fixes:
        """Of another table with these columns."""
        state = "fix" if "fix" in names else "t_s"
        return cls([names.index(name) for name in (state, *_PLACE)], 1 if state == "fix" else 0)

    def texts(self, rows: NDArray[np.float64]) -> Iterator[tuple[int, bytes]]:
        """(time in ns, message) of the first good row of each second."""
        known = rows[:, self._columns]
        good = np.flatnonzero((known[:, 0] >= self._least) & np.isfinite(known).all(axis=1))
        slots = np.floor(rows[good, 0] / EACH_S + 1e-6)
        latest = np.maximum.accumulate(np.concatenate(([self._slot], slots)))
        chosen = good[slots > latest[:-1]]
        self._slot = latest[-1]
        for t_s, row in zip(rows[chosen, 0].tolist(), known[chosen, 1:].tolist(), strict=True):
            yield self._text(round(t_s * 1e9), *row)

    def _text(
        self, t_ns: int, latitude: float, longitude: float, height: float, *sigmas: float
    ) -> tuple[int, bytes]:
        sec, nsec = divmod(t_ns, 1_000_000_000)
        known = len(sigmas) == 3
        east, north, up = (sigma * sigma for sigma in sigmas) if known else (0.0, 0.0, 0.0)
        return t_ns, FIX % (
            sec,
            nsec,
            latitude,
            longitude,
            height,
            east,
            north,
            up,
            DIAGONAL if known else UNKNOWN,
        )
