"""Everything that a run leaves behind, behind one door: scores, capture, solution.csv, series, report.

    with Recorder(manifest, request.out_dir, outages=…) as recorder:
        …                       # board runs; recorder.add_… in batches of some seconds of virtual time
        return recorder.finish(…)

Leaving the `with` block without `finish` marks what was written as a run that did not reach its end.
Batches should span 10 to 30 virtual seconds: each costs some hundred microseconds however long it is.
"""

from __future__ import annotations

import contextlib
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from host.capture.writer import CaptureWriter
from host.record.atomic import write_whole
from host.record.can_course import CanCourse
from host.record.collector import Collector
from host.record.errors import UserError
from host.record.result import BusUse, CpuUse, Event, FaultUse, RunResult
from host.record.row_text import RowText
from host.record.run_data import BiasEstimate, GnssBatch, Innovation, MotionBatch, SolutionBatch, TaskTrace
from host.record.run_folder import RunFolder
from host.record.screens import FILE_SCALE, Screen, file_name, png
from host.record.tables import (
    SOLUTION,
    bias_rows,
    filter_rows,
    gnss_rows,
    innovation_rows,
    solution_rows,
)
from host.score.errors import solution_errors
from host.score.expectations import Limit, flat_figures, judge, with_solution_demanded
from host.score.rules import ScoringRules
from host.score.scorer import Score, Scorer

Floats = NDArray[np.float64]

SHOWN_PER_SECOND = 5
"""At most so many solutions a second go into the capture's topic; the raw link traffic holds them all."""

EVENTS_KEPT = 1000


class Recorder:
    """Records one run. With `out_dir` None it only scores and gathers series. Times are virtual."""

    def __init__(
        self,
        manifest: Mapping[str, Any],
        out_dir: Path | None,
        *,
        capture: bool = True,
        outages: Sequence[tuple[float, float]] = (),
        rules: ScoringRules | None = None,
        fit_recording: bool = False,
    ) -> None:
        self._manifest = dict(manifest)
        self._scorer = Scorer(rules, outages, fit_recording=fit_recording)
        self._collector = Collector(tuple(outages))
        self._events: list[Event] = []
        self._events_left_out = 0
        self._innovations: list[Innovation] = []
        self._biases: list[BiasEstimate] = []
        self._finished = False
        self._thinning = Thinning()
        self._folder = RunFolder(out_dir, manifest) if out_dir is not None else None
        self.capture: CaptureWriter | None = None
        if self._folder is not None:
            self._csv = self._folder.file("solution.csv.part").open("wb")
            self._csv.write(",".join(SOLUTION.columns).encode() + b"\n")
            self._csv_text = RowText.csv(SOLUTION.decimals)
            if capture:
                self.capture = CaptureWriter(self._folder.file("run.mcap"), manifest)

    # -- what comes in -----------------------------------------------------------------------------

    def add_solution(self, solution: SolutionBatch, truth: MotionBatch) -> None:
        """Solutions of the board with the truth at the same instants."""
        rows = solution_rows(solution, self._scorer.add_solution(solution, truth))
        self._collector.add_solution(rows, solution, truth)
        if self._folder is not None:
            self._csv.write(self._csv_text.text(rows))
        if self.capture is not None:
            self.capture.rows("/solution", self._thinning.thinned(rows))
        self._pass_on_slow_rows()

    def add_gnss(self, epochs: GnssBatch, truth: MotionBatch) -> None:
        """Receiver epochs as the board understood them, with the truth at the antenna."""
        rows = gnss_rows(epochs, self._scorer.add_gnss(epochs, truth))
        self._collector.add_gnss(rows, epochs, truth)
        if self.capture is not None:
            self.capture.rows("/gnss", rows)

    def add_covariance(self, t: float, covariance: Floats) -> None:
        """The filter's 9 × 9 covariance of [δr NED m, δv NED m/s, φ n rad] at `t`."""
        self._scorer.add_covariance(t, covariance)

    def add_innovation(self, innovation: Innovation) -> None:
        """Innovations of one GNSS update."""
        self._innovations.append(innovation)

    def add_bias(self, bias: BiasEstimate) -> None:
        """Slow filter states."""
        self._biases.append(bias)

    def add_event(self, t_ns: int, source: str, text: str) -> None:
        """Something worth telling."""
        if len(self._events) < EVENTS_KEPT:
            self._events.append(Event(t_ns / 1e9, source, text))
        else:
            self._events_left_out += 1
        if self.capture is not None:
            self.capture.event(t_ns, source, text)

    def add_trace(self, trace: TaskTrace) -> None:
        """A recorded window of one processor's tasks."""
        self._collector.add_trace(trace)

    def add_can_course(self, course: CanCourse) -> None:
        """When the frames of one identifier of a CAN bus came."""
        self._collector.data.can.append(course)

    def add_screen(self, screen: Screen) -> None:
        """What the board's display showed."""
        self._collector.data.screens.append(screen)

    def add_status(self, rows: Floats) -> None:
        """Counters that the board told, rows of `host.record.run_data.STATUS_COLUMNS`."""
        self._collector.data.status.add(rows)

    def add_sensor(self, rows: Floats) -> None:
        """How the inertial sensor is, rows of `host.record.tables.SENSOR`."""
        self._collector.add_sensor(rows)
        if self.capture is not None:
            self.capture.rows("/sensor", rows)

    def add_filters(self, which: Floats, status: Floats, solution: SolutionBatch, truth: MotionBatch) -> None:
        """What filters side by side take for the state, with the truth at the same instants."""
        rows = filter_rows(which, status, solution, solution_errors(solution, truth))
        self._collector.add_filters(rows)
        if self.capture is not None:
            self.capture.rows("/filter", rows)

    def so_far(self, duration_s: float) -> Score:
        """The figures of what has been scored by now; the latest seconds still wait."""
        return self._scorer.so_far(duration_s)

    # -- the end -----------------------------------------------------------------------------------

    def finish(
        self,
        *,
        duration_s: float,
        wall_s: float,
        state_hash: str,
        cpu: Sequence[CpuUse] = (),
        buses: Sequence[BusUse] = (),
        faults: Sequence[FaultUse] = (),
        expect: Mapping[str, Limit] | None = None,
        gnss_extra: Mapping[str, float | None] | None = None,
        metrics_extra: Mapping[str, float | None] | None = None,
    ) -> RunResult:
        """Score the run, write what is left to write, and tell the result.

        `gnss_extra`, `metrics_extra`: figures about the receiver and about the solution that the caller has
        measured itself.
        """
        self._pass_on_slow_rows()
        score = self._scorer.result(duration_s)
        self._collector.data.nees = self._scorer.nees_series
        gnss = {**score.gnss, **(gnss_extra or {})}
        metrics = {**score.metrics, **(metrics_extra or {})}
        figures = flat_figures(metrics, gnss, cpu, buses, faults, score.recording)
        result = RunResult(
            board=self._manifest["board"],
            scenario=self._manifest["scenario"],
            profile=self._manifest["profile"],
            seed=self._manifest["seed"],
            duration_s=duration_s,
            wall_s=wall_s,
            state_hash=state_hash,
            metrics=metrics,
            gnss=gnss,
            outages=score.outages,
            cpu=tuple(cpu),
            buses=tuple(buses),
            faults=tuple(faults),
            expectations=judge(with_solution_demanded(expect or {}), figures),
            events=self._all_events(duration_s),
            recording=score.recording,
            out_dir=self._folder.path if self._folder is not None else None,
            data=self._collector.data,
        )
        if self._folder is not None:
            self._write(self._folder, result)
        self._finished = True
        return result

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, _traceback: TracebackType | None
    ) -> None:
        if self._folder is None:
            return
        try:
            if not self._finished:
                self._mark_as_unfinished(self._folder, kind, error)
        finally:
            self._folder.release()
        if isinstance(error, OSError) and error.filename is None:
            raise UserError(
                f"--out {self._folder.path}: cannot be written: {error.strerror}; what was written so far is"
                " marked as incomplete; free some space or name another folder"
            ) from None

    def _mark_as_unfinished(
        self, folder: RunFolder, kind: type[BaseException] | None, error: BaseException | None
    ) -> None:
        if kind is not None and issubclass(kind, KeyboardInterrupt):
            status = "interrupted by the user"
        else:
            status = f"failed: {error}" if error is not None else "failed: the run was not finished"
        # A full disk, for example, must not hide the error that is being told.
        with contextlib.suppress(OSError):
            if self.capture is not None:
                self.capture.abandon()
        with contextlib.suppress(OSError):
            self._csv.close()
        with contextlib.suppress(UserError):
            folder.set_status(status)

    def _write(self, folder: RunFolder, result: RunResult) -> None:
        from host.report.page import render

        if self.capture is not None:
            self.capture.close({"state_hash": result.state_hash, "duration_s": f"{result.duration_s:.9f}"})
        self._csv.close()
        for number, screen in enumerate(self._collector.data.screens, start=1):
            folder.file(file_name(number)).write_bytes(png(screen.picture, FILE_SCALE))
        folder.file("solution.csv.part").replace(folder.file("solution.csv"))
        write_whole(folder.file("result.json"), json.dumps(result.to_dict(), indent=1) + "\n", "--out")
        write_whole(folder.file("report.html"), render(result, self._manifest), "--out")
        folder.set_status("complete", state_hash=result.state_hash, duration_s=result.duration_s)

    def _all_events(self, duration_s: float) -> tuple[Event, ...]:
        if self._events_left_out:
            text = f"{self._events_left_out} more events are not listed"
            return (*self._events, Event(duration_s, "host", text))
        return tuple(self._events)

    def _pass_on_slow_rows(self) -> None:
        """Innovations and slow states since the last batch, all at once."""
        if self._innovations:
            rows = innovation_rows(self._innovations)
            self._collector.data.innovations.add(rows)
            if self.capture is not None:
                self.capture.rows("/innovation", rows)
            self._innovations = []
        if self._biases:
            rows = bias_rows(self._biases)
            self._collector.data.biases.add(rows)
            if self.capture is not None:
                self.capture.rows("/bias", rows)
            self._biases = []


class Thinning:
    """Takes the first row of each fifth of a second; batches come in the order of time."""

    def __init__(self) -> None:
        self._last_slot = -1.0

    def thinned(self, rows: Floats) -> Floats:
        """Those of one batch."""
        slots = np.floor(rows[:, 0] * SHOWN_PER_SECOND + 1e-6)
        chosen = rows[np.diff(slots, prepend=self._last_slot) > 0]
        self._last_slot = max(self._last_slot, *slots[-1:].tolist())
        return chosen
