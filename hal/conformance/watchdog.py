"""Checks for `hal.watchdog.Watchdog`."""

from collections.abc import Callable
from typing import Protocol

from hal.watchdog import Watchdog

TIMEOUT_NS = 100_000_000


class WatchdogBench(Protocol):
    """A watchdog and whether it has bitten."""

    watchdog: Watchdog

    def wait(self, duration_ns: int) -> None:
        """Let time pass; a reset ends it."""
        ...

    def bitten(self) -> bool:
        """Whether the processor was reset."""
        ...


def sleeps_until_started(bench: WatchdogBench) -> None:
    """Nothing happens without `start`; a kick before it does not start it."""
    bench.watchdog.kick()
    bench.wait(5 * TIMEOUT_NS)
    assert not bench.bitten()


def bites_when_not_kicked(bench: WatchdogBench) -> None:
    """After the timeout, not before."""
    bench.watchdog.start(TIMEOUT_NS)
    bench.wait(TIMEOUT_NS * 8 // 10)
    assert not bench.bitten(), "bitten before the timeout"
    bench.wait(TIMEOUT_NS * 5 // 10)
    assert bench.bitten(), "not bitten after the timeout"


def kicks_keep_it_quiet(bench: WatchdogBench) -> None:
    """Each kick restarts the timeout."""
    bench.watchdog.start(TIMEOUT_NS)
    for _ in range(10):
        bench.wait(TIMEOUT_NS * 7 // 10)
        bench.watchdog.kick()
    assert not bench.bitten()
    bench.wait(TIMEOUT_NS * 13 // 10)
    assert bench.bitten()


CHECKS: tuple[Callable[[WatchdogBench], None], ...] = (
    sleeps_until_started,
    bites_when_not_kicked,
    kicks_keep_it_quiet,
)
