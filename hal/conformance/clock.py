"""Checks for `hal.clock.Clock` and the waiting of `hal.cpu.Cpu`."""

from collections.abc import Callable
from typing import Protocol

from hal.clock import Clock
from hal.cpu import Cpu


class ClockBench(Protocol):
    """A processor with its clock."""

    clock: Clock
    cpu: Cpu
    tolerance: float
    """Relative error that its crystal may have, and the processor's own delays on a live host."""

    def expect_delay(self, duration_ns: int) -> None:
        """`cpu.delay(duration_ns)` will be called next."""
        ...


def never_goes_backwards(bench: ClockBench) -> None:
    """Reading after reading, with and without work between."""
    last = bench.clock.now_ns()
    assert isinstance(last, int), f"the time is {last!r}; it must be an integer"
    for _ in range(100):
        bench.cpu.spend(1)
        now = bench.clock.now_ns()
        assert now >= last, f"the clock went from {last} to {now}"
        last = now


def polling_ends(bench: ClockBench) -> None:
    """A loop that waits for the clock comes to an end."""
    deadline = bench.clock.now_ns() + 10_000
    polls = 0
    while bench.clock.now_ns() < deadline:
        polls += 1
        assert polls < 10_000_000, "the clock stands still while it is polled"


def delay_takes_its_time(bench: ClockBench) -> None:
    """A delay is at least as long as asked for, by a clock that may be wrong by the tolerance."""
    for duration in (1_000, 1_000_000, 20_000_000):
        before = bench.clock.now_ns()
        bench.expect_delay(duration)
        bench.cpu.delay(duration)
        elapsed = bench.clock.now_ns() - before
        assert elapsed >= duration * (1 - bench.tolerance), f"delay of {duration} ns took {elapsed} ns"


CHECKS: tuple[Callable[[ClockBench], None], ...] = (never_goes_backwards, polling_ends, delay_takes_its_time)
