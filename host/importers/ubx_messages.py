"""UBX messages as epochs, satellites and raw measurements (pyubx2 decodes them).

NAV-PVT tells everything of an epoch; older receivers tell NAV-POSLLH, NAV-VELNED and NAV-SOL with one time of
week. Epochs lie on whole milliseconds of GPS time.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Any

from host.importers import topics
from host.importers.findings import Findings, Kind
from host.importers.log_calendar import Calendar
from host.importers.log_rows import LogRows
from host.importers.series import at_byte
from host.importers.time_base import NS, WEEK_NS

NAN = math.nan
MS = 1_000_000
FIXES = (2, 3, 4)
"""2-D, 3-D, GNSS with dead reckoning."""


class UbxMessages:
    """Takes decoded messages of one log. `on_epoch` hears the GPS time of each."""

    def __init__(
        self,
        file: str,
        rows: LogRows,
        calendar: Calendar,
        findings: Findings,
        on_epoch: Callable[[int], None],
    ) -> None:
        self._file = file
        self._rows = rows
        self._calendar = calendar
        self._findings = findings
        self._on_epoch = on_epoch
        self._epochs = topics.epochs(file, at_byte)
        self._satellites = topics.satellites(file, at_byte)
        self._observations = topics.observations(file, at_byte)
        self._week: int | None = None
        self._parts: dict[str, Any] = {}
        self._parts_ms = -1
        self._has_pvt = False

    def take(self, message: Any, place: int) -> None:
        """A message whose checksum is right."""
        handler = HANDLERS.get(message.identity)
        if handler is not None:
            handler(self, message, place)

    def finish(self) -> None:
        """The log has ended."""
        self._close_parts(0)

    def _pvt(self, m: Any, place: int) -> None:
        self._has_pvt = True
        if not (m.validDate and m.validTime):
            self._findings.note(Kind.NO_TIME, self._file, "NAV-PVT", [(at_byte(place), "")], text="left out")
            return
        try:
            moment = datetime(m.year, m.month, m.day, m.hour, m.min, min(m.second, 59), tzinfo=UTC)
        except ValueError:
            self._findings.note(
                Kind.UNREADABLE, self._file, "NAV-PVT", [(at_byte(place), "no date")], text="left out"
            )
            return
        unix_ns = int(moment.timestamp() + max(0, m.second - 59)) * NS + int(m.nano)
        gps_ns = round(self._calendar.gps_ns(unix_ns) / MS) * MS
        self._week = gps_ns // WEEK_NS
        fix = m.gnssFixOk == 1 and m.fixType in FIXES
        place_of = (m.lat, m.lon, m.height * 1e-3) if fix else (NAN, NAN, NAN)
        motion = (m.velN * 1e-3, m.velE * 1e-3, m.velD * 1e-3)
        accuracy = (m.hAcc * 1e-3, m.vAcc * 1e-3, m.sAcc * 1e-3)
        others = ((m.height - m.hMSL) * 1e-3, m.numSV, NAN, NAN)
        self._epoch(gps_ns, (float(fix), *place_of, *motion, *accuracy, *others), place)

    def _epoch(self, gps_ns: int, row: tuple[float, ...], place: int) -> None:
        self._rows.add(self._epochs, gps_ns, row, place)
        self._rows.stamp(gps_ns)
        self._on_epoch(gps_ns)

    def _timegps(self, m: Any, _place: int) -> None:
        if m.weekValid:
            self._week = m.week

    def _sat(self, m: Any, place: int) -> None:
        if self._week is None:
            return
        gps_ns = self._week * WEEK_NS + m.iTOW * MS
        for k in range(1, m.numSvs + 1):
            one = [
                getattr(m, f"{name}_{k:02d}") for name in ("gnssId", "svId", "elev", "azim", "cno", "svUsed")
            ]
            row = [float(value) for value in one]
            if row[2] < -90:  # not known
                row[2:4] = NAN, NAN
            self._rows.add(self._satellites, gps_ns, row, place)

    def _rawx(self, m: Any, place: int) -> None:
        self._week = m.week
        gps_ns = m.week * WEEK_NS + round(m.rcvTow * NS)
        for k in range(1, m.numMeas + 1):
            names = ("gnssId", "svId", "sigId", "prMes", "cpMes", "doMes", "cno")
            row = [float(getattr(m, f"{name}_{k:02d}")) for name in names]
            self._rows.add(self._observations, gps_ns, row, place)
        self._rows.stamp(gps_ns)

    def _part(self, m: Any, place: int) -> None:
        if m.iTOW != self._parts_ms:
            self._close_parts(place)
            self._parts_ms = m.iTOW
        if m.identity == "NAV-SOL" and m.wknSet:
            self._week = m.week
        self._parts[m.identity] = m

    def _close_parts(self, place: int) -> None:
        parts, self._parts = self._parts, {}
        position, motion, solution = (parts.get(f"NAV-{name}") for name in ("POSLLH", "VELNED", "SOL"))
        if position is None or self._has_pvt:
            return
        if self._week is None:
            self._findings.note(
                Kind.NO_TIME, self._file, "NAV-POSLLH", [(at_byte(place), "no week")], text="left out"
            )
            return
        fix = solution is None or (solution.gpsfixOK == 1 and solution.gpsFix in FIXES)
        place_of = (position.lat, position.lon, position.height * 1e-3) if fix else (NAN, NAN, NAN)
        velocity = [NAN] * 3 if motion is None else [getattr(motion, f"vel{axis}") * 1e-2 for axis in "NED"]
        s_acc = NAN if motion is None else motion.sAcc * 1e-2
        accuracy = (position.hAcc * 1e-3, position.vAcc * 1e-3, s_acc)
        count = NAN if solution is None else float(solution.numSV)
        others = ((position.height - position.hMSL) * 1e-3, count, NAN, NAN)
        gps_ns = self._week * WEEK_NS + self._parts_ms * MS
        self._epoch(gps_ns, (float(fix), *place_of, *velocity, *accuracy, *others), place)


HANDLERS: dict[str, Callable[[UbxMessages, Any, int], None]] = {
    "NAV-PVT": UbxMessages._pvt,
    "NAV-TIMEGPS": UbxMessages._timegps,
    "NAV-SAT": UbxMessages._sat,
    "RXM-RAWX": UbxMessages._rawx,
    "NAV-POSLLH": UbxMessages._part,
    "NAV-VELNED": UbxMessages._part,
    "NAV-SOL": UbxMessages._part,
}
