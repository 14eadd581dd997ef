"""Which figures are held against a baseline, and which way is worse.

Largest errors are left out: one value out of thousands moves by more than any tolerance when anything
changes.
"""

from __future__ import annotations

from collections.abc import Mapping

LESS_IS_BETTER = (
    *("outage_horizontal_drift_median_m", "nees_factor", "aligned_at_s", "epochs_without_solution"),
    *("covariances_not_positive", "deadline_misses", "overruns", "faults_not_fired"),
)
MORE_IS_BETTER = ("availability",)
KINDS_OF_ERROR = ("_rms_", "_p95_")
DID_NOT_FINISH = "did_not_finish"
"""1 for a run that did not reach its end, else 0."""


def direction(name: str) -> int:
    """+1: more is worse, −1: less is worse, 0: not held against a baseline."""
    if name in MORE_IS_BETTER:
        return -1
    if name in LESS_IS_BETTER or name == DID_NOT_FINISH:
        return 1
    if name.startswith("cpu.") and name.endswith(".load"):
        return 1
    own = not name.startswith(("gnss.", "expect.", "nees"))
    return int(own and any(kind in name for kind in KINDS_OF_ERROR))


def gated(figures: Mapping[str, object]) -> dict[str, float | None]:
    """The figures that are held against a baseline; None: could not be computed."""
    return {
        name: float(value) if isinstance(value, int | float) else None
        for name, value in figures.items()
        if direction(name)
    }
