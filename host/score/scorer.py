"""The scorer: solutions, covariances and receiver epochs go in as they come, the figures come out.

Fused solution and receiver alone are scored on the same epochs: each receiver epoch that counts (see
`host.score.rules`) gives one receiver error, against the truth at the antenna, and one error of the fused
solution, interpolated linearly between the two solutions around the same instant of validity. A solution
that is missing, not finite or not of a navigation mode there is not scored (`epochs_without_solution`).
Without a receiver every solution counts (`at_receiver_epochs` of the rules).
`availability` is the share of the seconds from alignment to the end of the run with a navigation solution.

Solutions, receiver epochs and covariances reach the host at different delays, so judgement waits
`HOLD_BACK_S` behind the newest solution. Memory is fixed, whatever the length of the run.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from host.record.result import Outage
from host.record.run_data import NAVIGATING, GnssBatch, MotionBatch, SolutionBatch
from host.record.series import DecimatedSeries
from host.score.consistency import departure, nees
from host.score.error_group import ErrorGroup
from host.score.errors import COLUMNS, position_error_ned, quaternions, solution_errors
from host.score.outages import OutageWatch
from host.score.recording_fit import RecordingFit
from host.score.rules import FIX_GAP_S, FixHistory, ScoringRules
from host.score.statistic import Statistic
from host.score.window import RecentRows

Floats = NDArray[np.float64]

HOLD_BACK_S = 3.0
NEES_KEPT = 1536
"""Instants of which the NEES is kept one by one, evenly thinned."""

_TIME, _FIX, _ERRORS, _VELOCITY, _ATTITUDE = 0, 1, slice(2, 8), slice(8, 11), slice(11, 15)
"""Columns of a waiting receiver epoch: its error, the true velocity there and the true q_nb."""


@dataclass(frozen=True, slots=True)
class Score:
    """All figures of a run: `metrics` of the fused solution, `gnss` of the receiver alone."""

    metrics: Mapping[str, float | None]
    gnss: Mapping[str, float | None]
    outages: tuple[Outage, ...]
    recording: Mapping[str, Any] | None


class Scorer:
    """Figures of one run. `outages` are (start, duration) in s, as the scenario declares them.

    The filter's attitude error φ, to which its covariance belongs, must have the sign of Ĉ = (I + [φ×]) C
    while δr and δv are estimated minus true, as the ψ of `host.score.errors`. It matters for NEES only.
    """

    def __init__(
        self,
        rules: ScoringRules | None = None,
        outages: Sequence[tuple[float, float]] = (),
        fit_recording: bool = False,
    ) -> None:
        self._rules = rules or ScoringRules()
        self._history = FixHistory(self._rules)
        self._recent = RecentRows(len(COLUMNS), span_s=HOLD_BACK_S + 2.0)
        self._aligned_at_s = math.inf
        self._fused = ErrorGroup()
        self._continuous = ErrorGroup("continuous_")
        self._receiver = ErrorGroup(with_attitude=False)
        self._nees = Statistic()
        self.nees_series = DecimatedSeries(("t_s", "nees"), NEES_KEPT)
        self._outages = OutageWatch(outages)
        self._fit = RecordingFit() if fit_recording else None
        self._epochs = self._missing = self._out_of_order = self._receiver_epochs = self._fixes = 0
        self._seconds_with_solution = 0
        self._last_second = -1
        self._last_verdict = (-math.inf, False)
        self._waiting_gnss: list[Floats] = []
        self._waiting_covariances: list[tuple[float, Floats]] = []

    # -- what comes in -----------------------------------------------------------------------------

    def add_solution(self, solution: SolutionBatch, truth: MotionBatch) -> Floats:
        """Take in solutions with the truth at the same instants; returns their errors (n, 12)."""
        errors = solution_errors(solution, truth)
        navigating = (solution.mode >= NAVIGATING) & np.isfinite(errors).all(axis=1)
        if math.isinf(self._aligned_at_s) and navigating.any():
            self._aligned_at_s = float(solution.t[np.argmax(navigating)])
        self._count_seconds(solution.t[navigating])
        self._out_of_order += self._recent.add(solution.t, np.where(navigating[:, None], errors, np.nan))
        late = solution.t >= self._aligned_at_s + self._rules.after_alignment_s
        self._continuous.add(errors[navigating & late])
        if not self._rules.at_receiver_epochs:
            self._score_all(errors, navigating, solution.t >= self._aligned_at_s)
        self._judge(self._recent.newest - HOLD_BACK_S)
        return errors

    def _score_all(self, errors: Floats, navigating: NDArray[np.bool_], aligned: NDArray[np.bool_]) -> None:
        """Every solution counts, once there was one."""
        self._fused.add(errors[navigating])
        self._epochs += int(np.count_nonzero(aligned))
        self._missing += int(np.count_nonzero(aligned & ~navigating))

    def _count_seconds(self, t: Floats) -> None:
        seconds = np.unique(np.floor(t).astype(np.int64))
        seconds = seconds[seconds > self._last_second]
        self._seconds_with_solution += len(seconds)
        if len(seconds):
            self._last_second = int(seconds[-1])

    def add_gnss(self, epochs: GnssBatch, truth: MotionBatch) -> Floats:
        """Take in receiver epochs, truth at the antenna; returns their errors (n, 6), NaN without fix."""
        rows = np.empty((len(epochs), 15))
        rows[:, _TIME] = epochs.t
        rows[:, _FIX] = epochs.fix
        rows[:, _ERRORS][:, :3] = position_error_ned(epochs, truth)
        rows[:, _ERRORS][:, 3:] = epochs.velocity_ned - truth.velocity_ned
        rows[~epochs.fix, _ERRORS] = np.nan
        rows[:, _VELOCITY] = truth.velocity_ned
        rows[:, _ATTITUDE] = quaternions(truth.yaw, truth.pitch, truth.roll)
        self._receiver_epochs += len(epochs)
        self._fixes += int(np.count_nonzero(epochs.fix))
        self._waiting_gnss.append(rows)
        return rows[:, _ERRORS].copy()

    def add_covariance(self, t: float, covariance: Floats) -> None:
        """Take in the filter's 9 × 9 covariance of [δr NED m, δv NED m/s, φ n rad] at `t`."""
        self._waiting_covariances.append((t, covariance))

    @property
    def buffered_rows(self) -> int:
        """Rows that wait to be judged; bounded by a few seconds of a run."""
        return len(self._recent) + sum(map(len, self._waiting_gnss)) + len(self._waiting_covariances)

    # -- judgement ---------------------------------------------------------------------------------

    def _judge(self, until: float) -> None:
        """Score everything up to `until`, then forget it."""
        self._outages.judge(until, self._recent)
        verdicts = self._judge_gnss(until)
        self._judge_covariances(until, verdicts)
        self._recent.forget_before(until)

    def _judge_gnss(self, until: float) -> Floats:
        """Score epochs up to `until`; returns rows (time, whether it counts), the last old one first."""
        verdicts = [self._last_verdict]
        rows = np.concatenate(self._waiting_gnss) if self._waiting_gnss else np.empty((0, 15))
        ripe = rows[:, _TIME] <= until
        self._waiting_gnss = [rows[~ripe]]
        rows = rows[ripe]
        for t, fix in rows[:, [_TIME, _FIX]].tolist():
            verdicts.append((t, self._history.take(t, bool(fix), self._aligned_at_s)))
        self._last_verdict = verdicts[-1]
        table = np.array(verdicts)
        self._score_pairs(rows[table[1:, 1] == 1])
        return table

    def _score_pairs(self, rows: Floats) -> None:
        fused = self._recent.at(rows[:, _TIME])
        there = np.isfinite(fused).all(axis=1)
        rows, fused = rows[there], fused[there]
        self._epochs += there.size
        self._missing += there.size - len(rows)
        self._fused.add(fused)
        self._receiver.add(rows[:, _ERRORS])
        if self._fit is not None:
            self._fit.add(fused, rows[:, _ERRORS], rows[:, _VELOCITY], rows[:, _ATTITUDE])

    def _judge_covariances(self, until: float, verdicts: Floats) -> None:
        ripe = [item for item in self._waiting_covariances if item[0] <= until]
        if not ripe:
            return
        self._waiting_covariances = [item for item in self._waiting_covariances if item[0] > until]
        t = np.array([item[0] for item in ripe])
        before = np.maximum(np.searchsorted(verdicts[:, 0], t, side="right") - 1, 0)
        counts = (verdicts[before, 1] == 1) & (t - verdicts[before, 0] <= FIX_GAP_S)
        errors = self._recent.at(t)[:, :9]
        counts &= np.isfinite(errors).all(axis=1)
        covariances = np.array([item[1] for item in ripe])
        found = nees(errors[counts], covariances[counts])
        self._nees.add(found)
        self.nees_series.add(np.column_stack((t[counts], found)))

    # -- what comes out ----------------------------------------------------------------------------

    def result(self, duration_s: float) -> Score:
        """Score what still waits and tell all figures. The scorer takes nothing in afterwards."""
        self._judge(math.inf)
        return self.so_far(duration_s)

    def so_far(self, duration_s: float) -> Score:
        """All figures of what has been scored by now; the latest seconds still wait."""
        outages = self._outages.finished()
        metrics = self._fused.figures()
        metrics["epochs"] = float(self._epochs)
        metrics["epochs_without_solution"] = float(self._missing)
        metrics["aligned_at_s"] = self._aligned_at_s if math.isfinite(self._aligned_at_s) else None
        metrics["seconds_with_solution"] = float(self._seconds_with_solution)
        metrics["availability"] = self._availability(duration_s)
        metrics["nees_mean"] = self._nees.mean()
        metrics["nees_factor"] = departure(self._nees.mean())
        metrics["nees_p95"] = self._nees.quantile(0.95)
        metrics["nees_max"] = self._nees.max()
        metrics["nees_epochs"] = float(self._nees.count)
        metrics["covariances_not_positive"] = float(self._nees.not_finite)
        metrics["solutions_out_of_order"] = float(self._out_of_order)
        metrics |= OutageWatch.figures(outages)
        metrics |= self._continuous.figures()
        gnss = self._receiver.figures()
        gnss["epochs"] = float(self._epochs)
        gnss["fix_share"] = self._fixes / self._receiver_epochs if self._receiver_epochs else None
        return Score(metrics, gnss, outages, self._fit.result() if self._fit is not None else None)

    def _availability(self, duration_s: float) -> float:
        if not math.isfinite(self._aligned_at_s):
            return 0.0
        wanted = math.ceil(duration_s - 1e-6) - math.floor(self._aligned_at_s)
        return min(1.0, self._seconds_with_solution / max(wanted, 1))
