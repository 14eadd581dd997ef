"""Local worker processes. One that dies takes its run with it and nothing else: a new one takes its place.

`concurrent.futures` gives up all waiting work when one process dies, so the few lines of supervision stand
here. Workers end by themselves when the process that started them is gone, at the latest at the next word of
progress (`host.run.runner.STEP_NS`).
"""

from __future__ import annotations

import base64
import contextlib
import multiprocessing
import os
import pickle
import signal
from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from multiprocessing import forkserver
from multiprocessing.connection import Connection, wait
from multiprocessing.context import BaseContext
from multiprocessing.process import BaseProcess

from host.campaign.journal import Outcome
from host.campaign.plan import Job
from host.campaign.preload import WARM_WITH
from host.campaign.row import failed
from host.campaign.work import Reduce, work
from host.record.errors import UserError
from host.record.result import RunRequest

MOST_DEATHS_IN_A_ROW = 20
"""So many workers that die one after another without a finished run between them: nothing will come of it."""


@dataclass
class Worker:
    """A process, the pipe to it, and the job that it has."""

    process: BaseProcess
    pipe: Connection
    job: Job


class LocalPool:
    """So many worker processes of this machine."""

    def __init__(self, workers: int, reduce: Reduce, first: RunRequest | None = None) -> None:
        self._count = workers
        self._reduce = reduce
        self._context = _context(first)
        self._workers: list[Worker] = []
        self._deaths_in_a_row = 0

    def outcomes(self, jobs: Iterable[Job]) -> Iterator[Outcome]:
        """Do all jobs; outcomes come as runs end. Leaving early ends the workers."""
        waiting = deque(jobs)
        try:
            while len(self._workers) < self._count and waiting:
                self._workers.append(self._start(waiting.popleft()))
            while self._workers:
                busy: list[Connection | int] = [worker.pipe for worker in self._workers]
                busy += [worker.process.sentinel for worker in self._workers]
                ready = wait(busy)
                for worker in list(self._workers):
                    if worker.pipe in ready or worker.process.sentinel in ready:
                        yield self._hear(worker, waiting)
        finally:
            self.stop()

    def stop(self) -> None:
        """End all workers, whatever they do."""
        for worker in self._workers:
            worker.process.kill()
        for worker in self._workers:
            worker.process.join()
            worker.pipe.close()
        self._workers.clear()

    def _hear(self, worker: Worker, waiting: deque[Job]) -> Outcome:
        """The outcome that a worker sends, or that of its death; the worker or a new one goes on."""
        try:
            outcome: Outcome = worker.pipe.recv()
        except (EOFError, OSError):
            return self._bury(worker, waiting)
        self._deaths_in_a_row = 0
        if waiting:
            worker.job = waiting.popleft()
            with contextlib.suppress(OSError):  # it died after it had told: the pipe's end tells so next time
                worker.pipe.send(worker.job)
        else:
            worker.pipe.close()
            worker.process.join()
            self._workers.remove(worker)
        return outcome

    def _bury(self, worker: Worker, waiting: deque[Job]) -> Outcome:
        worker.process.join()
        worker.pipe.close()
        self._workers.remove(worker)
        self._deaths_in_a_row += 1
        code = worker.process.exitcode or 0
        how = f"by signal {-code} ({_signal_name(-code)})" if code < 0 else f"with exit code {code}"
        if self._deaths_in_a_row >= MOST_DEATHS_IN_A_ROW:
            raise UserError(
                f"{self._deaths_in_a_row} worker processes died one after another, the last one {how};"
                " finished runs are kept. Is there memory enough? Try --workers 1"
            )
        if waiting:
            self._workers.append(self._start(waiting.popleft()))
        row = failed(worker.job, f"the worker process died {how}")
        return Outcome(worker.job.key, worker.job.number, row, again=True)

    def _start(self, job: Job) -> Worker:
        ours, theirs = self._context.Pipe()
        process = self._context.Process(target=_serve, args=(theirs, self._reduce), daemon=True)  # type: ignore[attr-defined]
        process.start()
        theirs.close()
        ours.send(job)
        return Worker(process, ours, job)


def _context(first: RunRequest | None) -> BaseContext:
    """Workers come from a clean process that is warm already, where the system has that."""
    if "forkserver" not in multiprocessing.get_all_start_methods():
        return multiprocessing.get_context("spawn")
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["host.campaign.preload"])
    if first is not None:
        os.environ[WARM_WITH] = base64.b64encode(pickle.dumps(first)).decode()
    forkserver.ensure_running()
    os.environ.pop(WARM_WITH, None)
    return context


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return "unknown"


def _serve(pipe: Connection, reduce: Reduce) -> None:
    """What a worker does: one job after another until nobody sends any more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # whoever started us decides what an interrupt ends
    while True:
        try:
            job: Job = pipe.recv()
            pipe.send(work(job, reduce, _must_have_a_parent))
        except (EOFError, OSError):
            return


def _must_have_a_parent() -> None:
    """End this process when the one that started it is gone: nobody would hear the outcome."""
    parent = multiprocessing.parent_process()
    if parent is not None and not parent.is_alive():
        os._exit(0)
