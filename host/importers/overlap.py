"""Whether the streams of a recording lie beside one another in time: clocks that differ are found by that."""

from __future__ import annotations

from host.importers.findings import Findings, Kind
from host.importers.series import Rows, Series
from host.importers.time_base import NS

COMPARED = ("/imu/", "/gnss", "/truth")
"""Topics, and beginnings of topics, that a replay needs together."""


class Overlap:
    """Follows when each of these series begins and ends."""

    def __init__(self, findings: Findings) -> None:
        self._findings = findings
        self._spans: dict[Series, tuple[int, int]] = {}

    def take(self, rows: Rows) -> None:
        """Sound rows of any series."""
        if rows.series.topic.startswith(COMPARED) and len(rows):
            begin_ns, _end_ns = self._spans.get(rows.series, (rows.first_ns, 0))
            self._spans[rows.series] = begin_ns, int(rows.times_ns[-1])

    def finish(self) -> bool:
        """Tell of each series that has no time in common with the first one; whether there is one."""
        is_apart = False
        first = next(iter(self._spans), None)
        for other in self._spans:
            assert first is not None
            begin_ns, end_ns = self._spans[first]
            other_begin_ns, other_end_ns = self._spans[other]
            if other_begin_ns > end_ns:
                far_s, what = (other_begin_ns - end_ns) / NS, f"begins behind the end of {first.topic}"
            elif other_end_ns < begin_ns:
                far_s, what = (begin_ns - other_end_ns) / NS, f"ends before {first.topic} begins"
            else:
                continue
            is_apart = True
            text = "their clocks differ, or they are not of one drive; taken as they are"
            self._findings.note(
                Kind.APART, other.file, other.topic, [(f"by {far_s:,.6g} s", what)], text=text
            )
        return is_apart
