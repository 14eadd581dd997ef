"""One run of a campaign, in whatever process: the same job gives the same outcome everywhere.

A process does one run after another and stays warm between them: imports, compiled kernels and everything
else that lasts is there from the second run on.
"""

from __future__ import annotations

import os
import threading
import time
import traceback
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from host.campaign.journal import Outcome
from host.campaign.plan import Job
from host.campaign.row import failed, finished
from host.record.errors import UserError
from host.record.result import RunResult

Reduce = Callable[[RunResult], dict[str, Any]]
"""What of a run's series is kept."""

_one_at_a_time = threading.Lock()
"""A cluster's process may have several threads; virtual time gains nothing from them."""
_warm = False


def work(job: Job, reduce: Reduce, alive: Callable[[], None] | None = None) -> Outcome:
    """Do a run. What fails, fails as a row; `alive` is called now and then and may end the process."""
    with _one_at_a_time:
        begin, begin_cpu = time.perf_counter(), time.process_time()
        try:
            result = _run(job, alive)
            outcome = Outcome(job.key, job.number, finished(job, result), reduce(result))
            times: dict[str, Any] = {"loop_s": result.wall_s}
        except UserError as error:
            outcome, times = Outcome(job.key, job.number, failed(job, str(error))), {}
        except Exception as error:
            row = failed(job, f"{type(error).__name__}: {error}")
            outcome, times = Outcome(job.key, job.number, row), {"traceback": traceback.format_exc()}
        settle_once()
        times |= {
            "total_s": time.perf_counter() - begin,
            "cpu_s": time.process_time() - begin_cpu,
            "process": os.getpid(),
        }
        return replace(outcome, times=times)


def _run(job: Job, alive: Callable[[], None] | None) -> RunResult:
    from host.run.runner import run

    progress = None if alive is None else lambda _reached, _duration: alive()
    return run(replace(job.request, progress=progress))


def settle_once() -> None:
    """After the first run: what lives now, lasts."""
    global _warm
    if not _warm:
        from host.run.garbage import settle

        settle()
        _warm = True
