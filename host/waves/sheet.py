"""One lane of a bus: what is to be drawn on its lines, and what is drawn and not yet written."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from host.waves.lines import Edge, Tracer, Unit


@dataclass(slots=True)
class Sheet:
    """One lane."""

    tracer: Tracer
    variables: list[Any]
    """Of the tracer's lines."""
    lane: int
    waiting: list[Unit] = field(default_factory=list)
    edges: list[Edge] = field(default_factory=list)
    end_ns: int = -(1 << 62)
    """Of the unit drawn last."""
    drawn: int = 0
    cut_short: int = 0

    def take(self, units: list[Unit]) -> None:
        """Further units of the lane, in the order in which they were told."""
        for unit in units:
            if unit.content is None:
                self.waiting = [told for told in self.waiting if told.begin_ns < unit.begin_ns]
            else:
                self.waiting.append(unit)
        self.waiting.sort(key=lambda unit: unit.begin_ns)

    def draw(self, unit: Unit) -> None:
        """One unit; one before that has not ended is cut short."""
        begin, gap = unit.begin_ns, self.tracer.gap_ns
        if self.end_ns > begin or (gap and self.end_ns == begin):
            self.cut_short += self.end_ns > begin
            self._let_go(begin - gap)
        self.edges += self.tracer.edges(unit)
        self.end_ns = unit.end_ns

    def written_before(self, time_ns: int) -> list[Edge]:
        """The edges before `time_ns`, which are given once."""
        edges = self.edges
        if not edges or edges[-1].time_ns < time_ns:
            self.edges = []
            return edges
        place = next(k for k, edge in enumerate(edges) if edge.time_ns >= time_ns)
        self.edges = edges[place:]
        return edges[:place]

    def _let_go(self, time_ns: int) -> None:
        self.edges = [edge for edge in self.edges if edge.time_ns < time_ns]
        idle = self.tracer.idle
        self.edges += [Edge(time_ns, line, idle[line]) for line in self.tracer.lanes[self.lane]]
