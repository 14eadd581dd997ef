"""A run's row of the result file: plain columns by the names that expectations use."""

from __future__ import annotations

from host.campaign.plan import Job
from host.campaign.swept_value import swept_value
from host.record.result import RunResult, finite_or_none
from host.score.expectations import flat_figures

FINISHED, FAILED = "finished", "failed"

Value = str | float | int | bool | None


def beginning(job: Job) -> dict[str, Value]:
    """Columns that are known before the run."""
    row: dict[str, Value] = {"run": job.number, "profile": job.setup.profile, "seed": job.request.seed}
    row |= {f"set.{key}": swept_value(text) for key, text in job.setup.swept}
    return row


def finished(job: Job, result: RunResult) -> dict[str, Value]:
    """The row of a run that reached its end."""
    row: dict[str, Value] = beginning(job) | {
        "status": FINISHED,
        "error": None,
        "met": result.ok,
        "duration_s": result.duration_s,
        "state_hash": result.state_hash,
    }
    row |= flat_figures(result.metrics, result.gnss, result.cpu, result.buses, result.faults)
    for number, outage in enumerate(result.outages):
        row[f"outages.{number}.horizontal_drift_m"] = outage.horizontal_drift_m
        row[f"outages.{number}.vertical_drift_m"] = outage.vertical_drift_m
    for one in result.expectations:
        row[f"expect.{one.name}.relation"] = one.relation
        row[f"expect.{one.name}.limit"] = one.limit
        row[f"expect.{one.name}.met"] = one.ok
    cleaned: dict[str, Value] = finite_or_none(row)
    return cleaned


def failed(job: Job, error: str) -> dict[str, Value]:
    """The row of a run that did not reach its end."""
    return beginning(job) | {"status": FAILED, "error": error, "met": False}
