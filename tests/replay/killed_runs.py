"""Runs in processes that die by SIGKILL at a virtual time."""

from __future__ import annotations

import contextlib
import os
import signal
from pathlib import Path

from host.record.result import RunRequest
from host.run import runner, session


def killed_at(moment_ns: int, request: RunRequest) -> Path:
    """The capture that a run leaves behind which is killed at `moment_ns`."""
    child = os.fork()
    if child == 0:
        make_ready = session.make_ready

        def make_ready_to_die(*arguments):
            ready = make_ready(*arguments)
            ready.board.time.at(moment_ns, lambda: os.kill(os.getpid(), signal.SIGKILL))
            return ready

        with contextlib.suppress(BaseException):
            session.make_ready = make_ready_to_die
            runner.run(request)
        os._exit(1)
    _, status = os.waitpid(child, 0)
    assert os.WIFSIGNALED(status)
    return request.out_dir / "run.mcap.part"
