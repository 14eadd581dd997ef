"""A finished run in a test: its figures, and limits that it must keep."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Self

import pytest

from host.record.command_line import command_line
from host.record.errors import UserError
from host.record.result import Expectation, RunRequest, RunResult
from host.report.numbers import number
from host.report.summary import MET, NOT_MET, limit_text
from host.score.expectations import bare, check_names, flat_figures, judge, with_solution_demanded
from host.sim.scenario.schema import limit_of


class CheckedRun:
    """What `navtwin_run()` gives. `result` is the whole RunResult; `run["yaw_rms_deg"]` is one figure."""

    def __init__(self, result: RunResult, request: RunRequest, note: Callable[[str, str], None]) -> None:
        self.result = result
        self._request = request
        self._note = note
        self._figures = flat_figures(
            result.metrics, result.gnss, result.cpu, result.buses, result.faults, result.recording
        )

    def __getitem__(self, name: str) -> float | None:
        """A figure by the name that expectations use; None when it could not be computed."""
        __tracebackhide__ = True
        if bare(name) not in self._figures:
            self._check({name: limit_of(0.0)})
        return self._figures[bare(name)]

    @property
    def command(self) -> str:
        """The command line that makes this run again."""
        return command_line(self._request)

    def expect(self, limits: Mapping[str, Any] | None = None, /, **more: Any) -> Self:
        """Fail the test unless the figures keep their limits, which are written as under `[expect]`.

        `expect(yaw_rms_deg=1.5, availability=">= 0.99")`; names with dots go into a dict,
        `expect({"cpu.mcu.load": 0.05})`. Without arguments: the limits of the scenario itself. As there, a
        run without any solution keeps no limits unless they speak of that.
        """
        __tracebackhide__ = True
        wanted = {**(limits or {}), **more}
        judged = self._judged(wanted) if wanted else self._of_scenario()
        for one in judged:
            self._note(one.name, f"{one.value!r} {one.relation} {one.limit!r}")
        if not all(one.ok for one in judged):
            raise AssertionError(self._told(judged, wanted))
        return self

    def _judged(self, wanted: Mapping[str, Any]) -> Sequence[Expectation]:
        __tracebackhide__ = True
        parsed = {}
        mistake = ""
        for name, value in wanted.items():
            try:
                parsed[name] = limit_of(value)
            except ValueError as error:
                mistake = mistake or f"expect({name}={value!r}): {error}"
        if mistake:
            pytest.fail(mistake, pytrace=False)
        self._check(parsed)
        return judge(with_solution_demanded(parsed), self._figures)

    def _of_scenario(self) -> Sequence[Expectation]:
        __tracebackhide__ = True
        if not self.result.expectations:
            pytest.fail(
                f"expect(): the scenario {self.result.scenario} has no [expect];"
                " name the limits, e.g. expect(yaw_rms_deg=1.5)",
                pytrace=False,
            )
        return self.result.expectations

    def _check(self, limits: Mapping[str, Any]) -> None:
        """A figure that does not exist is a mistake in the test."""
        __tracebackhide__ = True
        result = self.result
        lists = {"cpu": result.cpu, "buses": result.buses, "faults": result.faults}
        parts = {head: [part.name for part in items] for head, items in lists.items()}  # type: ignore[attr-defined]
        mistake = ""
        try:
            check_names(limits, parts, result.board, recording=result.recording is not None)
        except UserError as error:
            mistake = str(error)
        if mistake:
            pytest.fail(mistake, pytrace=False)

    def _told(self, judged: Sequence[Expectation], wanted: Mapping[str, Any]) -> str:
        result = self.result
        missed = sum(not one.ok for one in judged)
        run = f"{result.board} {result.scenario} {result.profile} seed {result.seed}"
        lines = [f"{run}: {missed} of {len(judged)} expectations NOT MET"]
        width = max(len(one.name) for one in judged)
        for one in judged:
            verdict = MET if one.ok else NOT_MET
            lines.append(
                f"  {verdict:7}  {one.name:{width}}  {number(one.value)}, limit {limit_text(one)}"
                + ("" if one.ok else f"  (exact: {one.value!r} {one.relation} {one.limit!r})")
            )
        lines += [f"seed: {result.seed}", f"reproduce: {command_line(self._request, wanted or None)}"]
        if result.out_dir is not None:
            lines.append(f"report: {result.out_dir / 'report.html'}")
        return "\n".join(lines)
