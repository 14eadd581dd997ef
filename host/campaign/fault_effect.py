"""What a fault did to a run, seen against the same run without it."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from host.campaign.can_effect import CanEffect, can_course, can_effect
from host.campaign.fault_plan import Strike
from host.campaign.fault_told import told, told_course
from host.record.result import RunResult
from host.record.run_data import NAVIGATING

Floats = NDArray[np.float64]

GAP_S = 0.5
EXCESS = (5.0, 1.0, 3.0)
"""Of position m, velocity m/s, attitude °: a solution is good when none of its errors is more than this above
that of the run without fault."""
KNOWN_BY = (
    ("latitude_deg", "longitude_deg", "height_m"),
    ("v_north_mps", "v_east_mps", "v_down_mps"),
    ("yaw_deg", "pitch_deg", "roll_deg"),
)
"""A board that does not know one of the three sends zeros: then its error says nothing."""
UNAIDED = np.array((False, False, True))
"""Of a board without receiver: its position and velocity drift away, with the fault and without."""
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
    worst: tuple[float | None, float | None, float | None]
    """Largest horizontal m, velocity m/s, attitude ° error of a navigation solution from the strike on; None:
    the board has none."""
    usual: tuple[float | None, float | None, float | None]
    """The same without the fault."""
    without_solution_s: float
    degraded_s: float
    recovered_after_s: float | None
    """Until solutions were good again and CAN frames came as usual; where neither suffered, until the board's
    last word about it."""
    solutions_differ: bool = True
    """Whether any solution is another than in the run without the fault."""
    can: CanEffect | None = None
    """None: the board has no CAN."""
    error: str = ""
    """Set when the run did not reach its end."""

    @property
    def verdict(self) -> str:
        """In a word."""
        if self.error:
            return "run failed"
        if not self.fired:
            return "did not strike"
        detected = self.detected_after_s is not None
        if not self.suffered and not detected:
            return "not observed"
        if self.recovered_after_s is None:
            return "not recovered" if self.suffered else "told only"
        return "recovered" if detected else "not told"

    @property
    def suffered(self) -> bool:
        """Whether solutions or CAN frames are others than in the run without the fault."""
        return self.solutions_differ or (self.can is not None and self.can.differs)

    @property
    def ok(self) -> bool:
        """The fault struck and did no lasting harm that can be seen."""
        return self.verdict in ("recovered", "not told", "told only", "not observed")


def fault_course(result: RunResult) -> dict[str, Any]:
    """What is kept of a run: errors and modes of its solutions, and what the board said."""
    assert result.data is not None
    solution = result.data.solution
    named = {name: solution.column(name) for name in solution.columns}
    errors = (
        np.hypot(named["error_north_m"], named["error_east_m"]),
        _norm(named, "error_v_north_mps", "error_v_east_mps", "error_v_down_mps"),
        np.abs([named[f"error_{angle}_deg"] for angle in ("roll", "pitch", "yaw")]).max(axis=0),
    )
    for values, names in zip(errors, KNOWN_BY, strict=True):
        if not any(np.any(np.nan_to_num(named[name])) for name in names):
            values[:] = np.nan
    columns = np.stack((named["t_s"], named["mode"], *errors))
    return {
        "float64": base64.b64encode(columns.astype("<f8").tobytes()).decode(),
        "fired": [fault.fired for fault in result.faults],
        "duration_s": result.duration_s,
        "has_receiver": result.gnss.get("fix_share", 0.0) is not None,
        "can": can_course(result),
        **told_course(result),
    }


def effect(strike: Strike, series: Mapping[str, Any], usual: Mapping[str, Any]) -> Effect:
    """The effect of a fault from the courses of the run with it and of the run without."""
    t, mode, errors = _columns(series)
    usual_t, usual_mode, usual_errors = _columns(usual)
    usual_navigating = usual_mode >= NAVIGATING
    known = np.isfinite(usual_errors[:, usual_navigating]).any(axis=1)
    navigating = (mode >= NAVIGATING) & np.isfinite(errors[known]).all(axis=0) & known.any()
    after, end_s = t >= strike.at_s, float(series["duration_s"])
    good = navigating.copy()
    aided = bool(usual.get("has_receiver", True))
    for one in np.flatnonzero(known if aided else known & UNAIDED):
        there = usual_navigating & np.isfinite(usual_errors[one])
        good &= errors[one] <= np.interp(t, usual_t[there], usual_errors[one][there]) + EXCESS[one]
    ended_s = strike.at_s + (strike.duration_s or 0.0)
    heard = told(strike.at_s, ended_s, series, usual)
    differ = series["float64"] != usual["float64"]
    can = can_effect(strike.at_s, end_s - SETTLED_S, series["can"], usual["can"])
    over: list[float | None] = [_recovered(strike, t, good, end_s)] if differ else []
    over += [can.recovered_after_s] if can is not None and can.differs else []
    if not over:
        over = [None if heard.last_s is None else heard.last_s - strike.at_s]
    return Effect(
        strike=strike,
        fired=sum(series["fired"]),
        detected_after_s=None if heard.first_s is None else heard.first_s - strike.at_s,
        said=heard.said,
        worst=_largest(errors[:, after & (mode >= NAVIGATING)]),
        usual=_largest(usual_errors[:, (usual_t >= strike.at_s) & usual_navigating]),
        without_solution_s=_without(t, navigating, strike.at_s, end_s),
        degraded_s=float(np.sum(np.diff(t, append=t[-1:])[after & (mode == DEGRADED)])),
        recovered_after_s=_latest(over),
        solutions_differ=differ,
        can=can,
    )


def _latest(times_s: list[float | None]) -> float | None:
    """None when any of them never came."""
    known = [one for one in times_s if one is not None]
    return max(known) if len(known) == len(times_s) else None


def _norm(named: Mapping[str, Floats], *names: str) -> Floats:
    length: Floats = np.sqrt(sum(named[name] ** 2 for name in names))
    return length


def _columns(series: Mapping[str, Any]) -> tuple[Floats, Floats, Floats]:
    """Times, modes, and a row each of position, velocity and attitude errors."""
    flat = np.frombuffer(base64.b64decode(series["float64"]), dtype="<f8").reshape(5, -1)
    return flat[0], flat[1], flat[2:]


def _largest(errors: Floats) -> tuple[float | None, float | None, float | None]:
    position, velocity, attitude = (
        float(np.nanmax(row)) if np.isfinite(row).any() else None for row in errors
    )
    return position, velocity, attitude


def _without(t: Floats, navigating: NDArray[np.bool_], at_s: float, end_s: float) -> float:
    """Seconds after the strike without a navigation solution; gaps up to GAP_S are none."""
    good = t[navigating & (t >= at_s)]
    gaps = np.diff(np.concatenate(([at_s], good, [end_s])))
    return float(gaps[gaps > GAP_S].sum())


def _recovered(strike: Strike, t: Floats, good: NDArray[np.bool_], end_s: float) -> float | None:
    """Until the solutions stay good and come without a gap; None when that never happens."""
    after = t >= strike.at_s
    good_t = np.concatenate(([strike.at_s], t[after & good], [end_s]))
    gap_ends = good_t[1:][np.diff(good_t) > GAP_S]
    bad_t = t[after & ~good]
    last_bad = max([strike.at_s, *bad_t[-1:].tolist(), *gap_ends[-1:].tolist()])
    return None if last_bad > end_s - SETTLED_S else last_bad - strike.at_s
