"""NMEA 0183 sentences as epochs: those of one time of day belong together (pynmeagps decodes them).

Heights are made ellipsoidal with the geoid's separation of the same sentence, or a stated one; without either
there is none. Velocity is speed and course over ground; NMEA tells no vertical one (u-blox PUBX,00 does).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from datetime import date, time
from typing import Any

from host.importers import topics
from host.importers.findings import Findings, Kind
from host.importers.log_calendar import Calendar
from host.importers.log_rows import LogRows
from host.importers.series import Series
from host.importers.time_base import unix_day

NAN = math.nan
KNOT, KMH = 1852.0 / 3600.0, 1.0 / 3.6
SYSTEMS = {"GP": 0, "GA": 2, "GB": 3, "BD": 3, "GQ": 5, "QZ": 5, "GL": 6}
SBAS_NUMBERS = range(33, 65)
TIMED = {"GGA", "RMC", "GLL", "GNS", "ZDA", "GST"}


class NmeaEpochs:
    """Takes decoded sentences of one log."""

    def __init__(
        self,
        file: str,
        place: Callable[[int], str],
        rows: LogRows,
        calendar: Calendar,
        findings: Findings,
        geoid_separation: float | None,
        with_positions: bool = True,
    ) -> None:
        """`with_positions` False: another source in the log tells them better."""
        self._file = file
        self._rows = rows
        self._calendar = calendar
        self._findings = findings
        self._geoid_separation = geoid_separation
        self._with_positions = with_positions
        self._epochs: Series = topics.epochs(file, place)
        self._satellites = topics.satellites(file, place)
        self._attitudes = topics.attitude(file, place, is_paced=False)
        self._time_ns: int | None = None
        self._open: dict[str, Any] = {}
        self._place = 0

    def take(self, sentence: Any, place: int) -> None:
        """A sentence with a right checksum."""
        kind = sentence.msgID
        if kind in TIMED or (sentence.talker == "P" and kind == "UBX"):
            time_ns = _time_of_day(getattr(sentence, "time", None))
            if time_ns is not None:
                self._begin(time_ns, place)
        handler = getattr(self, f"_{kind.lower()}", None)
        if handler is not None:
            handler(sentence)
        elif sentence.talker == "P" and hasattr(sentence, "trueHdg"):
            self._pashr(sentence, place)
        elif sentence.talker == "P" and kind == "UBX" and hasattr(sentence, "vVel"):
            self._pubx(sentence)

    def close(self) -> None:
        """The epoch under way is over."""
        time_ns, told = self._time_ns, self._open
        self._time_ns, self._open = None, {}
        if time_ns is None:
            return
        if "day" in told:
            self._calendar.date(told["day"], time_ns)
        row, satellites, heading, place = self._row(told), self._sky(told), told.get("heading"), self._place

        def placed(gps_ns: int) -> None:
            if row is not None and self._with_positions:
                self._rows.add(self._epochs, gps_ns, row, place)
            for one in satellites:
                self._rows.add(self._satellites, gps_ns, one, place)
            if heading is not None:
                self._rows.add(self._attitudes, gps_ns, (heading, NAN, NAN, NAN, NAN, NAN, NAN), place)
            self._rows.stamp(gps_ns)

        self._calendar.place(time_ns, placed)

    def _begin(self, time_ns: int, place: int) -> None:
        if self._time_ns is not None and time_ns != self._time_ns:
            self.close()
        if self._time_ns is None:
            self._time_ns, self._place = time_ns, place

    # -- sentences ---------------------------------------------------------------------------------

    def _gga(self, s: Any) -> None:
        self._position(s, isinstance(s.quality, int) and s.quality > 0)
        separation = _number(s.sep)
        if math.isnan(separation) and self._geoid_separation is not None:
            separation = self._geoid_separation
        height = _number(s.alt)
        if str(s.altUnit).upper() == "F":
            self._findings.note(Kind.UNIT, self._file, "GGA altitude", text="in feet, as it says; converted")
            height *= 0.3048
        self._open |= {"height": height + separation, "separation": separation, "hdop": _number(s.HDOP)}
        self._open["satellites"] = _number(s.numSV)
        if math.isnan(separation) and not math.isnan(height):
            text = "height above the ellipsoid is not known; state one with --geoid-separation"
            self._findings.note(Kind.MISSING, self._file, "geoid separation", text=text)

    def _gns(self, s: Any) -> None:
        self._position(s, any(letter not in "N" for letter in str(s.posMode)))
        separation = _number(s.sep)
        self._open |= {
            "height": _number(s.alt) + separation,
            "separation": separation,
            "hdop": _number(s.HDOP),
        }
        self._open["satellites"] = _number(s.numSV)

    def _rmc(self, s: Any) -> None:
        self._position(s, s.status == "A")
        if isinstance(s.date, date):
            self._open["day"] = unix_day(s.date)
        self._motion(_number(s.spd) * KNOT, _number(s.cog))

    def _gll(self, s: Any) -> None:
        self._position(s, s.status == "A")

    def _zda(self, s: Any) -> None:
        try:
            self._open["day"] = unix_day(date(int(s.year), int(s.month), int(s.day)))
        except (TypeError, ValueError):
            return

    def _vtg(self, s: Any) -> None:
        speed = _number(s.sogk) * KMH
        self._motion(_number(s.sogn) * KNOT if math.isnan(speed) else speed, _number(s.cogt))

    def _hdt(self, s: Any) -> None:
        heading = _number(s.headingT)
        if not math.isnan(heading):
            self._open["heading"] = heading

    def _gsa(self, s: Any) -> None:
        used = self._open.setdefault("used", set())
        used |= {
            value for name, value in vars(s).items() if name.startswith("svid_") and isinstance(value, int)
        }

    def _gsv(self, s: Any) -> None:
        system = SYSTEMS.get(s.talker)
        if system is None:
            return
        sky = self._open.setdefault("sky", [])
        for k in range(1, 5):
            number = getattr(s, f"svid_{k:02d}", None)
            if isinstance(number, int):
                told = [_number(getattr(s, f"{name}_{k:02d}", None)) for name in ("elv", "az", "cno")]
                sky.append((1 if system == 0 and number in SBAS_NUMBERS else system, number, *told))

    def _pashr(self, s: Any, place: int) -> None:
        time_ns = _time_of_day(getattr(s, "utctime", None))
        angles = [_number(getattr(s, name, None)) for name in ("trueHdg", "pitch", "roll")]
        if time_ns is None or math.isnan(angles[0]):
            return
        row = (*angles, NAN, NAN, NAN, NAN)
        self._calendar.place(time_ns, lambda gps_ns: self._rows.add(self._attitudes, gps_ns, row, place))

    def _pubx(self, s: Any) -> None:
        self._position(s, str(s.navStat) not in ("NF", "TT"))
        self._motion(_number(s.SOG) * KMH, _number(s.COG))
        self._open |= {"down": _number(s.vVel), "h_acc": _number(s.hAcc), "v_acc": _number(s.vAcc)}
        self._open |= {"height": _number(s.altRef), "hdop": _number(s.HDOP), "satellites": _number(s.numSVs)}

    # -- an epoch ----------------------------------------------------------------------------------

    def _position(self, s: Any, has_fix: bool) -> None:
        latitude, longitude = _number(s.lat), _number(s.lon)
        known = has_fix and not math.isnan(latitude) and not math.isnan(longitude)
        self._open["fix"] = max(self._open.get("fix", 0), int(known))
        if known and ("latitude" not in self._open or s.msgID in ("GGA", "GNS", "UBX")):
            self._open |= {"latitude": latitude, "longitude": longitude}

    def _motion(self, speed: float, course: float) -> None:
        if not math.isnan(speed):
            self._open["speed"] = speed
        if not math.isnan(course):
            self._open["course"] = course

    def _row(self, told: dict[str, Any]) -> tuple[float, ...] | None:
        if "fix" not in told:
            return None
        speed, course = told.get("speed", NAN), math.radians(told.get("course", NAN))
        fix = told["fix"]
        place = [told.get(name, NAN) if fix else NAN for name in ("latitude", "longitude", "height")]
        motion = (speed * math.cos(course), speed * math.sin(course), told.get("down", NAN))
        accuracy = (told.get("h_acc", NAN), told.get("v_acc", NAN), NAN)
        others = (told.get("separation", NAN), told.get("satellites", NAN), told.get("hdop", NAN), NAN)
        return (float(fix), *place, *motion, *accuracy, *others)

    def _sky(self, told: dict[str, Any]) -> list[tuple[float, ...]]:
        used = told.get("used", set())
        return [(*one, float(one[1] in used)) for one in told.get("sky", [])]


def _time_of_day(value: object) -> int | None:
    if not isinstance(value, time):
        return None
    seconds = (value.hour * 60 + value.minute) * 60 + value.second
    return (seconds * 1_000_000 + value.microsecond) * 1000


def _number(value: object) -> float:
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else NAN
