"""The runner: one request, one run of virtual time, one result."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

from hal.emulated.virtual_time import SECOND
from host.record.result import Progress, RunRequest, RunResult
from host.run.readiness import make_ready, prepared
from host.run.session import RunSession, manifest_of, session_in_world
from host.run.setup import Setup
from host.sim.world import World

STEP_NS = 40 * SECOND
"""Virtual time between two words of progress."""


def run(request: RunRequest) -> RunResult:
    """Run a board. Raises UserError for whatever the user can mend."""
    setup, world = prepared(request)
    return run_in_world(request, setup, world, manifest_of(request, setup))


def run_in_world(request: RunRequest, setup: Setup, world: World, manifest: Mapping[str, Any]) -> RunResult:
    """Run a board in a world that is there already; faults are those of the world's scenario."""
    with session_in_world(request, setup, world, manifest) as session:
        return session.finish(_work_off(session, request.progress))


def check(request: RunRequest) -> float:
    """Do all that comes before virtual time, kernels included, and nothing more. Raises UserError.

    Returns how long the run will be, s of virtual time.
    """
    setup, world = prepared(request)
    make_ready(request, setup, world).surroundings.close()
    return world.duration_ns / SECOND


def _work_off(session: RunSession, progress: Progress | None) -> float:
    """Let all virtual time pass; returns the wall-clock seconds it took, generation and scoring included."""
    duration_ns = session.world.duration_ns
    begin = time.perf_counter()
    while session.now_ns < duration_ns:
        session.run_until(min(session.now_ns + STEP_NS, duration_ns))
        if progress is not None:
            progress(session.now_ns / SECOND, duration_ns / SECOND)
    session.look()
    return time.perf_counter() - begin
