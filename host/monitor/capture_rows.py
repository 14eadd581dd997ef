"""Rows of a capture's JSON topics as messages of the link, where there is no raw traffic of the board.

Rows are of `host.record.tables`, or of an imported recording; a value that is null or missing is NaN. A
reference solution (`/truth`) is shown like a board's where there is none.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

from firmware.drivers import gnss_epoch as epoch
from firmware.drivers.satellite_lists import SatelliteInView
from firmware.link import frames
from firmware.nav.flags import NAVIGATING
from host.link.messages import Bias, Gnss, Innovation, Satellites, Solution
from host.monitor.recorded import ATTITUDE, INERTIAL, Attitude, Inertial
from host.monitor.state import Shown
from host.record.tables import INNOVATION, SLOW_STATES

NANO = 1e9
LARGEST = 1e15
"""What is larger is no quantity of a vehicle."""
SHOWN = ("/solution", "/gnss", "/innovation", "/bias", "/satellites", "/truth", "/attitude", "/imu/")
"""Topics, and beginnings of topics, one of which a file must have."""
SAMPLE_EACH_NS = 100_000_000
"""Inertial samples between two that are shown are left out."""
SYSTEMS = {0: "GPS", 1: "SBAS", 2: "Galileo", 3: "BeiDou", 5: "QZSS", 6: "GLONASS"}
"""Of imported lists of satellites."""

Row = Mapping[str, Any]


def is_shown(topic: str) -> bool:
    """Whether rows of this topic say something to the view."""
    return topic in SHOWN or topic.startswith(SHOWN[-1])


class Rows:
    """Opens rows in the order of the file. `has_solution`: the file has a board's own."""

    def __init__(self, has_solution: bool) -> None:
        self._has_solution = has_solution
        self._sampled_ns: dict[str, int] = {}
        self._list_us = -1
        self._list: list[SatelliteInView] = []

    def message(self, topic: str, time_ns: int, data: bytes) -> tuple[int, Shown] | None:
        """(kind, message) of a row as it stands in the file; None when it says nothing to the view."""
        if topic.startswith(SHOWN[-1]):
            if time_ns - self._sampled_ns.get(topic, -SAMPLE_EACH_NS) < SAMPLE_EACH_NS:
                return None
            self._sampled_ns[topic] = time_ns
        try:
            row = json.loads(data)
        except ValueError:
            return None
        return self._open(topic, time_ns // 1000, row) if isinstance(row, dict) else None

    def _open(self, topic: str, time_us: int, row: Row) -> tuple[int, Shown] | None:
        match topic:
            case "/solution":
                return _solution(time_us, row)
            case "/truth":
                return None if self._has_solution else _solution(time_us, row)
            case "/gnss":
                return _gnss(time_us, row)
            case "/innovation":
                return _innovation(time_us, row)
            case "/bias":
                return _bias(time_us, row)
            case "/satellites":
                return self._satellite(time_us, row)
            case "/attitude":
                angles = (math.radians(_value(row, f"{name}_deg")) for name in ("yaw", "pitch", "roll"))
                return ATTITUDE, Attitude(time_us, *angles)
            case "/event":
                return frames.TEXT, f"{row.get('source', '?')}: {row.get('text', '')}"
            case _:
                return _inertial(time_us, row)

    def _satellite(self, time_us: int, row: Row) -> tuple[int, Shown]:
        """Each row adds one to the list of its time."""
        if time_us != self._list_us:
            self._list_us, self._list = time_us, []
        system = SYSTEMS.get(_whole(row, "system", -1), "other")
        angles = [_whole(row, f"{name}_deg", None) for name in ("elevation", "azimuth")]
        cn0 = _whole(row, "cn0_dbhz", None)
        number, used = _whole(row, "number", 0), bool(row.get("used"))
        self._list.append(SatelliteInView(system, number, angles[0], angles[1], cn0, used))
        return frames.SATELLITES, Satellites(time_us, 0, 1, tuple(self._list))


def _value(row: Row, name: str) -> float:
    value = row.get(name)
    return float(value) if isinstance(value, int | float) and abs(value) < LARGEST else math.nan


def _whole(row: Row, name: str, otherwise: Any) -> Any:
    value = _value(row, name)
    return round(value) if math.isfinite(value) else otherwise


def _to_si(name: str, value: float) -> float:
    return math.radians(value) if name.endswith(("_deg", "_dps")) else value


def _nanodeg(row: Row, name: str) -> int | None:
    value = _value(row, name)
    return round(value * NANO) if math.isfinite(value) and abs(value) <= 360.0 else None


def _solution(time_us: int, row: Row) -> tuple[int, Shown] | None:
    lat, lon = _nanodeg(row, "latitude_deg"), _nanodeg(row, "longitude_deg")
    if lat is None or lon is None:
        return None
    names = ("height_m", "v_north_mps", "v_east_mps", "v_down_mps")
    angles = ("yaw_deg", "pitch_deg", "roll_deg")
    sigmas = [f"sigma_{axis}_m" for axis in ("north", "east", "down")]
    sigmas += [f"sigma_v_{axis}_mps" for axis in ("north", "east", "down")]
    tilts = [f"sigma_psi_{axis}_deg" for axis in "ned"]
    return frames.SOLUTION, Solution._make(
        (
            time_us,
            frames.NO_TIME_OF_DAY,
            frames.NO_DATE,
            _whole(row, "mode", NAVIGATING) & 0xFF,
            _whole(row, "flags", 0) & 0xFFFF_FFFF,
            lat,
            lon,
            *(_value(row, name) for name in names),
            *(math.radians(_value(row, name)) for name in angles),
            *(math.nan,) * 3,
            *(_value(row, name) for name in sigmas),
            *(math.radians(_value(row, name)) for name in tilts),
        )
    )


def _gnss(time_us: int, row: Row) -> tuple[int, Shown]:
    lat, lon = _nanodeg(row, "latitude_deg"), _nanodeg(row, "longitude_deg")
    height = _value(row, "height_m")
    north, east, down = (_value(row, f"v_{axis}_mps") for axis in ("north", "east", "down"))
    speed, accuracy = math.hypot(north, east), _value(row, "h_acc_m")
    flags = 0
    if row.get("fix") and lat is not None and lon is not None:
        flags = epoch.HAS_POSITION
        flags |= epoch.HAS_HEIGHT if math.isfinite(height) else 0
        flags |= epoch.HAS_SPEED if math.isfinite(speed) else 0
        flags |= epoch.HAS_COURSE if speed > 0.3 else 0
        flags |= epoch.HAS_ACCURACY if math.isfinite(accuracy) else 0
    course = math.degrees(math.atan2(east, north)) % 360.0
    hundredths = _value(row, "hdop") * 100
    return frames.GNSS, Gnss(
        time_us,
        frames.NO_TIME_OF_DAY,
        frames.NO_DATE,
        flags,
        lat or 0,
        lon or 0,
        _thousandths(height),
        0,
        _thousandths(speed),
        round(course * 1e5) if math.isfinite(course) else 0,
        _thousandths(north),
        _thousandths(east),
        _thousandths(down),
        _whole(row, "satellites", 0),
        round(hundredths) if math.isfinite(hundredths) else 0,
        _thousandths(accuracy),
        _thousandths(_value(row, "v_acc_m")),
    )


def _thousandths(value: float) -> int:
    return round(value * 1000) if math.isfinite(value) else 0


def _innovation(time_us: int, row: Row) -> tuple[int, Shown]:
    values = (_value(row, name) for name in INNOVATION.columns[1:13])
    return frames.INNOVATION, Innovation((time_us, _whole(row, "used", 0) & 0x3F, *values))


def _bias(time_us: int, row: Row) -> tuple[int, Shown]:
    values = [_to_si(name, _value(row, name)) for name in SLOW_STATES]
    sigmas = [_to_si(name, _value(row, f"sigma_{name}")) for name in SLOW_STATES]
    return frames.BIAS, Bias((time_us, *values, *sigmas))


def _inertial(time_us: int, row: Row) -> tuple[int, Shown]:
    x, y, z = (math.radians(_value(row, f"rate_{axis}_dps")) for axis in "xyz")
    f_x, f_y, f_z = (_value(row, f"force_{axis}_mps2") for axis in "xyz")
    return INERTIAL, Inertial(time_us, (x, y, z), (f_x, f_y, f_z))
