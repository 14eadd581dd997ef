"""A campaign from its plan to its files: check, go on where a journal ends, run, sum up."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol

from boards.description import load_board
from boards.places import board_folder
from host.campaign.folder import RESULT, open_folder
from host.campaign.identity import campaign_manifest
from host.campaign.journal import Journal, Outcome
from host.campaign.plan import Job, Plan
from host.campaign.row import Value
from host.campaign.table import must_have_parquet, write_table
from host.record.errors import UserError
from host.run.setup import scenario_path

Notice = Callable[[str], None]


class Executor(Protocol):
    """Something that does jobs, in any order and anywhere."""

    def outcomes(self, jobs: Iterable[Job]) -> Iterator[Outcome]:
        """The outcome of each job, as it ends. To be closed when left early."""
        ...


@dataclass(frozen=True)
class Finished:
    """All runs of a campaign, in the order of its plan."""

    plan: Plan
    manifest: dict[str, Any]
    folder: Path
    outcomes: tuple[Outcome, ...]
    resumed: int
    """Runs that were there already."""

    @property
    def rows(self) -> list[dict[str, Value]]:
        """The rows of the result file."""
        return [outcome.row for outcome in self.outcomes]


def make_plan(
    board: str,
    scenario: str | None,
    profiles: Sequence[str],
    seeds: tuple[int, ...],
    fixed: tuple[str, ...],
    swept: tuple[tuple[str, tuple[str, ...]], ...],
    data_dir: Path | None,
) -> Plan:
    """A plan with the board's own choices filled in and paths that hold in every process."""
    description = load_board(board)
    place = board_folder(board)
    known = place.parent == Path(__file__).parents[2] / "boards"
    path = scenario_path(board, scenario or description.default_scenario)
    return Plan(
        board=board if known else str(place.resolve()),
        scenario=str(path.resolve()) if scenario and Path(scenario).is_file() else path.stem,
        profiles=tuple(profiles) or (description.default_profile,),
        seeds=seeds,
        fixed=fixed,
        swept=swept,
        data_dir=None if data_dir is None else data_dir.resolve(),
    )


def run_campaign(
    plan: Plan,
    folder: Path,
    executor: Executor,
    *,
    kind: str = "campaign",
    fresh: bool = False,
    notice: Notice | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Finished:
    """Do what of the campaign is not done yet, or all of it when `fresh`; finished runs are always kept.

    Raises UserError for what the user can mend, before the first run where that is possible; OSError when
    the disk is full.
    """
    must_have_parquet()
    manifest = campaign_manifest(plan, kind)
    check_setups(plan, notice)
    with open_folder(folder, manifest, fresh) as journal:
        jobs = list(plan.jobs())
        waiting = [job for job in jobs if _is_to_do(journal, job)]
        try:
            _work_off(journal, executor, waiting, len(jobs), progress)
        except BaseException:
            with contextlib.suppress(UserError):  # the disk may be full: the journal is what counts
                journal.read_again()
                _compile(plan, manifest, folder, journal, len(jobs) - len(waiting))
            raise
        return _compile(plan, manifest, folder, journal, len(jobs) - len(waiting))


def check_setups(plan: Plan, notice: Notice | None) -> None:
    """Do everything that comes before virtual time once for each set-up. Raises UserError."""
    from host.run.runner import check

    for setup in plan.setups():
        try:
            check(replace(plan.request(setup, plan.seeds[0]), notice=notice))
        except UserError as error:
            where = (
                " with " + ", ".join(f"{key}={value}" for key, value in setup.swept) if setup.swept else ""
            )
            raise UserError(f"the campaign was not begun{where}: {error}") from None


def _is_to_do(journal: Journal, job: Job) -> bool:
    outcome = journal.outcomes.get(job.key)
    return outcome is None or outcome.again


def _work_off(
    journal: Journal,
    executor: Executor,
    waiting: Sequence[Job],
    total: int,
    progress: Callable[[int, int], None] | None,
) -> None:
    done = total - len(waiting)
    if progress is not None:
        progress(done, total)
    if not waiting:
        return
    outcomes = executor.outcomes(waiting)
    try:
        for outcome in outcomes:
            journal.add(outcome)
            done += 1
            if progress is not None:
                progress(done, total)
    finally:
        close = getattr(outcomes, "close", None)
        if close is not None:
            close()


def _placed(outcome: Outcome, number: int) -> Outcome:
    """An outcome at its place in a plan that may have got more seeds since."""
    return replace(outcome, number=number, row={**outcome.row, "run": number})


def _compile(plan: Plan, manifest: dict[str, Any], folder: Path, journal: Journal, resumed: int) -> Finished:
    """Write the result file of what the journal holds."""
    done = journal.outcomes
    outcomes = tuple(_placed(done[job.key], job.number) for job in plan.jobs() if job.key in done)
    if outcomes:
        write_table(folder / RESULT, [outcome.row for outcome in outcomes], manifest, len(plan))
    return Finished(plan, manifest, folder, outcomes, resumed)
