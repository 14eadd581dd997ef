"""What a fault did to a run, seen against the same run without it."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from host.campaign.fault_plan import Strike
from host.record.result import RunResult
from host.record.run_data import NAVIGATING

Floats = NDArray[np.float64]

GAP_S = 0.5
EXCESS_M = 5.0
"""A solution is good when its horizontal error is no more than this above that of the run without fault."""
SAME_EVENT_S = 0.5
SETTLED_S = 5.0
"""So long before the end of the run the last bad solution must lie."""
DEGRADED = 4


@dataclass(frozen=True, slots=True)
class Effect:
    """One line of the sheet. Times are s from the strike; None: never."""

    strike: Strike
    fired: int
    detected_after_s: float | None
    said: str
    """The board's first word about it."""
    worst_error_m: float | None
    """Largest horizontal error of a navigation solution from the strike on."""
    usual_error_m: float | None
    """The same without the fault."""
    without_solution_s: float
    degraded_s: float
    recovered_after_s: float | None
    error: str = ""
    """Set when the run did not reach its end."""

    @property
    def verdict(self) -> str:
        """In a word."""
        if self.error:
            return "run failed"
        if not self.fired:
            return "did not strike"
        if self.recovered_after_s is None:
            return "not recovered"
        return "recovered" if self.detected_after_s is not None else "not told"

    @property
    def ok(self) -> bool:
        """The fault struck and was survived."""
        return self.verdict in ("recovered", "not told")


def fault_course(result: RunResult) -> dict[str, Any]:
    """What is kept of a run: errors and modes of its solutions, and what the board said."""
    assert result.data is not None
    solution = result.data.solution
    error = np.hypot(solution.column("error_north_m"), solution.column("error_east_m"))
    columns = np.stack((solution.column("t_s"), error, solution.column("mode")))
    return {
        "float64": base64.b64encode(columns.astype("<f8").tobytes()).decode(),
        "events": [[event.at_s, event.source, event.text] for event in result.events],
        "fired": [fault.fired for fault in result.faults],
        "duration_s": result.duration_s,
    }


def effect(strike: Strike, series: Mapping[str, Any], usual: Mapping[str, Any]) -> Effect:
    """The effect of a fault from the courses of the run with it and of the run without."""
    t, error, mode = _columns(series)
    usual_t, usual_error, usual_mode = _columns(usual)
    navigating = (mode >= NAVIGATING) & np.isfinite(error)
    after = t >= strike.at_s
    usual_after = (usual_t >= strike.at_s) & (usual_mode >= NAVIGATING)
    told = _first_word(strike, series["events"], usual["events"])
    return Effect(
        strike=strike,
        fired=sum(series["fired"]),
        detected_after_s=None if told is None else told[0] - strike.at_s,
        said="" if told is None else told[1],
        worst_error_m=_largest(error[after & navigating]),
        usual_error_m=_largest(usual_error[usual_after]),
        without_solution_s=_without(t, navigating, strike.at_s, float(series["duration_s"])),
        degraded_s=float(np.sum(np.diff(t, append=t[-1:])[after & (mode == DEGRADED)])),
        recovered_after_s=_recovered(
            strike, t, error, navigating, (usual_t, usual_error), float(series["duration_s"])
        ),
    )


def _columns(series: Mapping[str, Any]) -> tuple[Floats, Floats, Floats]:
    flat = np.frombuffer(base64.b64decode(series["float64"]), dtype="<f8").reshape(3, -1)
    return flat[0], flat[1], flat[2]


def _largest(values: Floats) -> float | None:
    return float(values.max()) if len(values) else None


def _first_word(strike: Strike, events: list[list[Any]], usual: list[list[Any]]) -> tuple[float, str] | None:
    """The board's first event after the strike that the run without fault does not have there."""
    for at_s, source, text in events:
        if source != "board" or at_s < strike.at_s:
            continue
        expected = any(other[1:] == [source, text] and abs(other[0] - at_s) < SAME_EVENT_S for other in usual)
        if not expected:
            return at_s, text
    return None


def _without(t: Floats, navigating: NDArray[np.bool_], at_s: float, end_s: float) -> float:
    """Seconds after the strike without a navigation solution; gaps up to GAP_S are none."""
    good = t[navigating & (t >= at_s)]
    gaps = np.diff(np.concatenate(([at_s], good, [end_s])))
    return float(gaps[gaps > GAP_S].sum())


def _recovered(
    strike: Strike,
    t: Floats,
    error: Floats,
    navigating: NDArray[np.bool_],
    usual: tuple[Floats, Floats],
    end_s: float,
) -> float | None:
    """Until the solutions stay good and come without a gap; None when that never happens."""
    usual_error = np.interp(t, usual[0], np.nan_to_num(usual[1], nan=0.0)) if len(usual[0]) else 0.0
    good = navigating & (error <= usual_error + EXCESS_M)
    after = t >= strike.at_s
    good_t = np.concatenate(([strike.at_s], t[after & good], [end_s]))
    gap_ends = good_t[1:][np.diff(good_t) > GAP_S]
    bad_t = t[after & ~good]
    last_bad = max([strike.at_s, *bad_t[-1:].tolist(), *gap_ends[-1:].tolist()])
    return None if last_bad > end_s - SETTLED_S else last_bad - strike.at_s
