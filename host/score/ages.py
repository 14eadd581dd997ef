"""How old data are: mean, 95 % and largest, in the memory of a histogram."""

from __future__ import annotations

from collections import defaultdict

STEP_US = 10
"""Resolution of the percentile."""
STEP_NS = STEP_US * 1000
AGE_FIGURES = tuple(
    f"{name}_{figure}_us"
    for name in ("age_of_data", "sample_to_epoch", "epoch_to_line")
    for figure in ("mean", "p95", "max")
)
"""Among `metrics` of boards with chips that tell when a sample was taken; `host.run.age_of_data` measures."""


class Ages:
    """Ages of one kind, ns."""

    def __init__(self) -> None:
        self._steps: defaultdict[int, int] = defaultdict(int)
        self._count = self._sum = self._largest = 0

    def add(self, age_ns: int) -> None:
        """One more."""
        self._count += 1
        self._sum += age_ns
        if age_ns > self._largest:
            self._largest = age_ns
        self._steps[age_ns // STEP_NS] += 1

    def figures(self) -> tuple[float | None, float | None, float | None]:
        """Mean, 95 % and largest, µs."""
        if not self._count:
            return None, None, None
        left = self._count * 0.95
        for step in sorted(self._steps):
            left -= self._steps[step]
            if left <= 0:
                break
        p95_us = min((step + 1) * STEP_US, self._largest / 1000)
        return self._sum / self._count / 1000, p95_us, self._largest / 1000
