"""The pace on a clock that the test moves: when slices are worked off, what is late, what is given up."""

from __future__ import annotations

import numpy as np
import pytest

from host.serve.lateness import Lateness
from host.serve.pacing import PacedRun

MS = 1_000_000


class Clock:
    def __init__(self):
        self.ns = 5_000_000_000

    def __call__(self):
        return self.ns


class Session:
    """Takes `cost_ns` of the clock for each slice, and notes when each was worked off."""

    def __init__(self, clock, cost_ns=0):
        self.clock, self.cost_ns = clock, cost_ns
        self.now_ns = 0
        self.worked = []
        self.looks = 0

    def run_until(self, end_ns):
        assert end_ns >= self.now_ns
        self.now_ns = end_ns
        self.clock.ns += self.cost_ns
        self.worked.append((self.clock.ns, end_ns))

    def look(self):
        self.looks += 1


class Outside:
    def __init__(self, clock, at=None):
        self.clock, self.at = clock, at or {}
        self.held = 0
        self.waited = []

    def bring_in(self): ...

    def hand_out(self): ...

    def look_around(self): ...

    def holds_up(self):
        self.held -= self.held > 0
        return self.held > 0

    def wait(self, seconds):
        self.waited.append(seconds)
        self.clock.ns += round(seconds * 1e9)
        for time_ns in [t for t in self.at if t <= self.clock.ns]:
            self.at.pop(time_ns)()


def paced(pace, cost_ns=0):
    clock = Clock()
    session = Session(clock, cost_ns)
    outside = Outside(clock)
    return PacedRun(session, outside, pace, clock), session, outside, clock


@pytest.mark.parametrize("pace", [0.25, 1.0, 7.5])
def test_virtual_time_keeps_step_with_the_clock_and_is_never_early(pace):
    run, session, _outside, clock = paced(pace)
    begin = clock.ns
    run.run(round(3e9 * pace))
    assert (clock.ns - begin) / 1e9 == pytest.approx(3.0, abs=1e-6)
    for wall_ns, virtual_ns in session.worked:
        assert virtual_ns <= (wall_ns - begin) * pace + 1
    figures = run.lateness.figures()
    assert figures["deadlines"] == 300
    assert figures["within_2_ms"] == 1.0
    assert run.slips == 0
    assert session.now_ns == round(3e9 * pace)


def test_a_slice_that_comes_late_is_made_up_for_without_losing_time():
    run, session, outside, clock = paced(1.0)
    begin = clock.ns

    def stall():
        clock.ns += 300 * MS

    outside.at[begin + 500 * MS] = stall
    run.run(2_000 * MS)
    assert clock.ns - begin == 2_000 * MS
    assert run.slips == 0
    assert run.lateness.max_ns >= 295 * MS
    assert run.lateness.count == 200
    late = [wall - begin - virtual for wall, virtual in session.worked if virtual > 900 * MS]
    assert max(late) == 0


def test_more_than_a_second_behind_is_given_up_and_told():
    run, _session, outside, clock = paced(1.0)
    begin = clock.ns

    def suspended():
        clock.ns += 5_000 * MS

    outside.at[begin + 500 * MS] = suspended
    run.run(1_000 * MS)
    assert run.slips == 1
    assert run.slipped_s == pytest.approx(5.0, abs=0.01)
    assert clock.ns - begin == pytest.approx(6_000 * MS, abs=3 * MS)


def test_a_machine_too_slow_for_the_pace_says_so_and_still_waits_for_clients():
    run, session, outside, _clock = paced(10.0, cost_ns=4 * MS)
    run.run(60_000 * MS)
    assert run.slips > 0
    assert run.slipped_s + 6.0 == pytest.approx(run.running_s, abs=1.1)
    assert len(outside.waited) >= len(session.worked)


def test_while_paused_no_time_passes_and_none_is_owed_afterwards():
    run, session, outside, clock = paced(1.0)
    begin = clock.ns
    outside.at[begin + 300 * MS] = run.pause
    outside.at[begin + 3_300 * MS] = run.resume
    run.run(1_000 * MS)
    assert clock.ns - begin == pytest.approx(4_000 * MS, abs=60 * MS)
    assert run.running_s == pytest.approx(1.0, abs=0.06)
    assert run.slips == 0
    assert run.lateness.max_ns == 0
    assert session.now_ns == 1_000 * MS


def test_without_a_pace_the_run_waits_for_whoever_reads_and_for_nothing_else():
    run, session, outside, clock = paced(0.0)
    outside.held = 5
    begin = clock.ns
    run.run(10_000 * MS)
    assert session.now_ns == 10_000 * MS
    assert sum(seconds > 0 for seconds in outside.waited) == 4
    assert clock.ns - begin == round(sum(outside.waited) * 1e9)


def test_stop_ends_it_in_the_middle():
    run, session, outside, clock = paced(1.0)
    outside.at[clock.ns + 250 * MS] = run.stop
    run.run(1_000 * MS)
    assert session.now_ns == pytest.approx(250 * MS, abs=2 * MS)


def test_percentiles_and_histogram_agree_with_numpy():
    late_ns = np.random.default_rng(1).gamma(1.5, 0.6 * MS, 20_000).astype(np.int64)
    lateness = Lateness()
    for one in late_ns.tolist():
        lateness.add(one)
    figures = lateness.figures()
    for name, share in (("p50_ms", 0.5), ("p95_ms", 0.95), ("p99_ms", 0.99)):
        assert figures[name] == pytest.approx(np.quantile(late_ns, share) / MS, abs=0.011)
    jitter = np.abs(np.diff(late_ns))
    assert figures["jitter_p99_ms"] == pytest.approx(np.quantile(jitter, 0.99) / MS, abs=0.02)
    assert figures["within_2_ms"] == np.mean(late_ns <= 2 * MS)
    assert figures["max_ms"] == late_ns.max() / MS
    rows = lateness.histogram()
    edges = [0.0, *[row["up_to_ms"] for row in rows[:-1]], np.inf]
    counted, _ = np.histogram(late_ns / MS, edges)
    assert [row["deadlines"] for row in rows] == counted.tolist()
