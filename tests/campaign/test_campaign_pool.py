"""Local worker processes: what one run does to its worker touches no other run."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from campaign_rig import REST, rows

from host.campaign.campaign import run_campaign
from host.campaign.journal import Outcome
from host.campaign.plan import Plan
from host.campaign.pool import LocalPool
from host.campaign.summary import summarised
from host.record.result import RunResult

PLAN = Plan("car_mems", str(REST), ("full-rate",), (1, 2, 3, 4), ("duration_s=3",))
FIRST = next(PLAN.jobs()).request


def keep_seed(result: RunResult) -> dict[str, Any]:
    return {"seed": result.seed, "process": os.getpid()}


def die_with_seed_2(result: RunResult) -> dict[str, Any]:
    if result.seed == 2:
        os.kill(os.getpid(), signal.SIGKILL)
    return {"seed": result.seed}


def fail_with_seed_2(result: RunResult) -> dict[str, Any]:
    if result.seed == 2:
        raise ValueError("seed 2 is not to be had")
    return {"seed": result.seed}


def stop_at_seed_3(result: RunResult) -> dict[str, Any]:
    if result.seed == 3:
        raise SystemExit(7)
    return {"seed": result.seed}


def outcomes(reduce: Any, workers: int = 2) -> dict[int, Outcome]:
    found = {outcome.number: outcome for outcome in LocalPool(workers, reduce, FIRST).outcomes(PLAN.jobs())}
    assert sorted(found) == [0, 1, 2, 3]
    return found


def test_worker_that_is_killed_fails_its_run_only() -> None:
    found = outcomes(die_with_seed_2)
    assert found[1].row["status"] == "failed"
    assert found[1].row["error"] == "the worker process died by signal 9 (SIGKILL)"
    assert found[1].again
    assert [found[number].series for number in (0, 2, 3)] == [{"seed": 1}, {"seed": 3}, {"seed": 4}]


def test_error_in_a_run_is_its_row_and_the_worker_goes_on() -> None:
    found = outcomes(fail_with_seed_2, workers=1)
    assert found[1].row["error"] == "ValueError: seed 2 is not to be had"
    assert not found[1].again
    assert "fail_with_seed_2" in found[1].times["traceback"]
    assert [found[number].row["status"] for number in (0, 2, 3)] == ["finished"] * 3


def test_failed_run_is_a_row_of_the_result_and_of_the_summary(tmp_path: Path) -> None:
    finished = run_campaign(PLAN, tmp_path / "c", LocalPool(1, fail_with_seed_2, FIRST))
    found = rows(tmp_path / "c")
    assert [row["status"] for row in found] == ["finished", "failed", "finished", "finished"]
    assert found[1]["error"] == "ValueError: seed 2 is not to be had"
    assert found[1]["state_hash"] is None
    assert len(found[2]["state_hash"]) == 64
    summary = summarised(finished)
    assert summary.failures == (("full-rate seed=2", found[1]["error"]),)
    assert not summary.ok(1.0)


def test_worker_that_exits_is_told_with_its_code() -> None:
    assert outcomes(stop_at_seed_3)[2].row["error"] == "the worker process died with exit code 7"


def test_one_process_does_many_runs_and_ends() -> None:
    found = outcomes(keep_seed, workers=1)
    processes = {outcome.series["process"] for outcome in found.values()}
    assert len(processes) == 1
    with pytest.raises(ProcessLookupError):
        os.kill(processes.pop(), 0)


def test_leaving_early_ends_the_workers() -> None:
    coming = LocalPool(2, keep_seed).outcomes(PLAN.jobs())
    first = next(coming)
    coming.close()  # type: ignore[attr-defined]
    with pytest.raises(ProcessLookupError):
        os.kill(first.series["process"], 0)


class Dying:
    """An executor whose worker dies at every run."""

    def outcomes(self, jobs: Any) -> Iterator[Outcome]:
        for job in jobs:
            yield Outcome(
                job.key, job.number, {"run": job.number, "status": "failed", "met": False}, again=True
            )


def test_run_whose_worker_died_is_tried_again_by_the_next_resume(tmp_path: Path) -> None:
    died = run_campaign(PLAN, tmp_path / "c", Dying())
    assert [outcome.again for outcome in died.outcomes] == [True] * 4
    again = run_campaign(PLAN, tmp_path / "c", LocalPool(2, keep_seed))
    assert [outcome.row["status"] for outcome in again.outcomes] == ["finished"] * 4
    assert again.resumed == 0
