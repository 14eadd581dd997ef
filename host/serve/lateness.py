"""How late the deadlines of a paced run were: percentiles, a histogram, jitter, in constant memory."""

from __future__ import annotations

from collections.abc import Iterable

BIN_NS = 10_000
BINS = 20_000
"""Finer than 10 µs up to 200 ms; what is later than that is counted in one place."""
WITHIN_NS = 2_000_000
"""The share of deadlines within this is told."""
EDGES_MS = (0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)


class Lateness:
    """Gathers lateness in ns; what comes early counts as 0."""

    def __init__(self) -> None:
        self.count = 0
        self.within = 0
        self.max_ns = 0
        self._bins = [0] * (BINS + 1)
        self._jitter = [0] * (BINS + 1)
        self._last_ns: int | None = None

    def add(self, late_ns: int) -> None:
        """One deadline was met `late_ns` after its instant."""
        late_ns = max(0, late_ns)
        self.count += 1
        self.within += late_ns <= WITHIN_NS
        self.max_ns = max(self.max_ns, late_ns)
        self._bins[min(late_ns // BIN_NS, BINS)] += 1
        if self._last_ns is not None:
            self._jitter[min(abs(late_ns - self._last_ns) // BIN_NS, BINS)] += 1
        self._last_ns = late_ns

    def break_off(self) -> None:
        """The next deadline does not follow the last one: a pause lies between them."""
        self._last_ns = None

    @property
    def share_within(self) -> float | None:
        """Share of deadlines that were met within `WITHIN_NS`; None before the first."""
        return self.within / self.count if self.count else None

    def figures(self) -> dict[str, float | int | None]:
        """For people and programs; in ms."""
        return {
            "deadlines": self.count,
            "within_2_ms": self.share_within,
            "p50_ms": _quantile_ms(self._bins, 0.5),
            "p95_ms": _quantile_ms(self._bins, 0.95),
            "p99_ms": _quantile_ms(self._bins, 0.99),
            "max_ms": self.max_ns / 1e6 if self.count else None,
            "jitter_p50_ms": _quantile_ms(self._jitter, 0.5),
            "jitter_p99_ms": _quantile_ms(self._jitter, 0.99),
        }

    def histogram(self) -> list[dict[str, float | int | None]]:
        """How many deadlines lay up to each edge and beyond the one before; the last one has no edge."""
        rows: list[dict[str, float | int | None]] = []
        begin = 0
        for edge_ms in EDGES_MS:
            end = round(edge_ms * 1e6) // BIN_NS
            rows.append({"up_to_ms": edge_ms, "deadlines": sum(self._bins[begin:end])})
            begin = end
        rows.append({"up_to_ms": None, "deadlines": sum(self._bins[begin:])})
        return rows


def _quantile_ms(bins: Iterable[int], share: float) -> float | None:
    """Upper edge of the bin that holds the quantile; None: nothing was counted."""
    counts = list(bins)
    wanted = share * sum(counts)
    if not wanted:
        return None
    reached = 0
    for place, count in enumerate(counts):
        reached += count
        if reached >= wanted:
            return (place + 1) * BIN_NS / 1e6
    return None
