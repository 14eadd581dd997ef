"""The filters of gfsins beside what the document shows: rows of the table, with goals."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware.nav.gyro_free import layout as gl
from firmware.nav.gyro_free.filters import FilterConfig
from host.tables.chapter5 import Failure, chapter5
from host.tables.federated_run import Errors, FederatedErrors, run_federated, run_single
from host.tables.sensor_failure import SensorFailure

Array = NDArray[np.float64]
SETTLED_S = 60
"""What is before does not count in an RMS."""
FEEDBACK = "fusion_feedback"
WITHIN = 1.10
TILT_LIMIT_DEG = 0.4
YAW_OVER_SIGMA = (0.7, 1.3)
"""Of the GPS filter's heading: RMS of the error over what the filter takes it for."""
FAILURES = (
    Failure("compass", "silent"),
    Failure("compass", "stuck"),
    Failure("compass", "turned by 25°"),
    Failure("gps", "silent"),
    Failure("gps", "300 m off"),
)


@dataclass(frozen=True, slots=True)
class FilterRow:
    """RMS over time and seeds of one filter, and what the document says of it."""

    name: str
    tilt: float
    """rad, of roll and pitch together."""
    yaw: float
    velocity: float
    """m/s, of the three axes together."""
    position: float
    end_position: float
    """m, at the end."""
    document: str
    goal: str
    met: bool | None
    detail: dict[str, Any]
    shown: Errors
    """Of the first seed, for curves."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FailureRow(SensorFailure):
    """One sensor that fails on a drive of its own."""

    failure: Failure

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        more = {"failure": asdict(self.failure), "other_isolated": self.others_isolated}
        return super(FailureRow, self).to_dict() | more


def filter_rows(duration_s: int, seeds: Sequence[int]) -> Iterator[FilterRow]:
    """Compass filter, GPS filter, centralised, and the federation in its four modes, on the same drives."""
    feeds = [chapter5(duration_s, seed) for seed in seeds]
    config = FilterConfig()
    compass = [run_single(feed, config, True, False) for feed in feeds]
    yield _compass_row(compass)
    yield _gps_row([run_single(feed, config, False, True) for feed in feeds])
    central = [run_single(feed, config, True, True) for feed in feeds]
    reference = _row("centralised", central, "—", "the reference", None, {})
    yield reference
    for reset in gl.RESET_NAMES:
        runs = [run_federated(feed, FilterConfig(reset=reset)) for feed in feeds]
        yield _federated_row(reset, runs, reference)


def _compass_row(runs: Sequence[Errors]) -> FilterRow:
    began = max(float(np.max(np.abs(run.attitude[0]))) for run in runs)
    ended = _rms([run.attitude[-SETTLED_S:] for run in runs])
    position = [np.linalg.norm(run.position, axis=1) for run in runs]
    diverges = all(one[-1] > 3.0 * one[len(one) // 2] for one in position)
    return _row(
        "compass filter",
        runs,
        "attitude converges, position diverges",
        "the same",
        ended < began and diverges,
        {"attitude_began_rad": began, "attitude_last_minute_rad": ended},
    )


def _gps_row(runs: Sequence[Errors]) -> FilterRow:
    tilt = max(float(np.max(np.abs(run.attitude[SETTLED_S:, :2]))) for run in runs)
    ratio = [np.abs(run.attitude[:, 2]) / run.yaw_sigma for run in runs]
    grows = all(run.yaw_sigma[-1] > 10.0 * run.yaw_sigma[0] for run in runs)
    settled = _rms([run.position[SETTLED_S:] for run in runs]) < 5.0
    largest = max(float(np.max(one)) for one in ratio)
    typical = float(np.sqrt(np.mean(np.square(ratio))))
    honest = largest <= 3.0 and YAW_OVER_SIGMA[0] <= typical <= YAW_OVER_SIGMA[1]
    return _row(
        "GPS filter",
        runs,
        "velocity and position converge, attitude diverges",
        f"tilt within {TILT_LIMIT_DEG}°, heading grows as σ says",
        settled and grows and math.degrees(tilt) <= TILT_LIMIT_DEG and honest,
        {
            "tilt_largest_rad": tilt,
            "yaw_over_sigma_rms": typical,
            "yaw_over_sigma_largest": largest,
        },
    )


def _federated_row(reset: str, runs: Sequence[FederatedErrors], reference: FilterRow) -> FilterRow:
    row = _row(f"federated, {reset.replace('_', ' ')}", [run.master for run in runs], "", "", None, {})
    ratios = {
        "tilt": row.tilt / reference.tilt,
        "yaw": row.yaw / reference.yaw,
        "velocity": row.velocity / reference.velocity,
        "position": row.position / reference.position,
    }
    met = max(ratios.values()) <= WITHIN if reset == FEEDBACK else None
    goal = "within 10 % of the centralised" if reset == FEEDBACK else "stated"
    document = "all three converge" if reset == "no_reset" else ""
    isolated = bool(any(run.isolated.any() for run in runs))
    detail = {"over_centralised": ratios, "isolated": isolated}
    return replace(row, document=document, goal=goal, met=met, detail=detail)


def _row(
    name: str, runs: Sequence[Errors], document: str, goal: str, met: bool | None, detail: dict[str, Any]
) -> FilterRow:
    return FilterRow(
        name,
        _rms([run.attitude[SETTLED_S:, :2] for run in runs]),
        _rms([run.attitude[SETTLED_S:, 2:] for run in runs]),
        _rms([run.velocity[SETTLED_S:] for run in runs]),
        _rms([run.position[SETTLED_S:] for run in runs]),
        _rms([run.position[-1:] for run in runs]),
        document,
        goal,
        met,
        detail,
        runs[0],
    )


def _rms(parts: Sequence[Array]) -> float:
    """Of vectors: root of the mean squared length."""
    return float(np.sqrt(np.mean(np.concatenate([np.sum(part * part, axis=1) for part in parts]))))


def failure_rows(duration_s: int, seed: int, reset: str = FEEDBACK) -> Iterator[FailureRow]:
    """Each failure on a drive of its own."""
    for failure in FAILURES:
        run = run_federated(chapter5(duration_s, seed, failure), FilterConfig(reset=reset))
        yield _failure_row(failure, run)


def _failure_row(failure: Failure, run: FederatedErrors) -> FailureRow:
    which = gl.COMPASS if failure.sensor == "compass" else gl.GPS
    seconds = np.arange(1.0, len(run.isolated) + 1.0)
    isolated = run.isolated[:, which]
    found = seconds[isolated & (seconds > failure.start)]
    after = seconds[~isolated & (seconds > failure.end)]
    begun = seconds > failure.start
    position = np.linalg.norm(run.master.position[begun], axis=1)
    causes = run.cause[:, which][isolated]
    recovered = bool(len(found) and len(after)) and not isolated[-1]
    return FailureRow(
        name=f"{failure.sensor} {failure.kind}",
        cause=gl.CAUSE_NAMES[int(causes[0])] if len(causes) else gl.CAUSE_NAMES[0],
        detected_s=float(found[0] - failure.start) if len(found) else None,
        recovered_s=float(after[0] - failure.end) if recovered else None,
        worst_position_m=float(np.max(position)),
        worst_heading_deg=math.degrees(float(np.max(np.abs(run.master.attitude[begun, 2])))),
        failure=failure,
        others_isolated=bool(run.isolated[:, 1 - which].any()),
    )
