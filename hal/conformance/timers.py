"""Checks for `hal.timers`."""

from collections.abc import Callable
from typing import Protocol

from hal.interrupts import InterruptLine
from hal.timers import CaptureTimer, PeriodicTimer


class TimerBench(Protocol):
    """A periodic timer, and a capture timer whose pin the bench drives."""

    timer: PeriodicTimer
    capture: CaptureTimer

    def line(self, name: str, handler: Callable[[], None]) -> InterruptLine:
        """An interrupt line ("timer" or "capture") with this handler."""
        ...

    def expect(self, action: str) -> None:
        """The call `action` (as in a transcript) comes next."""
        ...

    def wait(self, duration_ns: int, expiries: int) -> None:
        """Let time pass, in which the timer must expire `expiries` times."""
        ...

    def edge(self) -> int | None:
        """One edge at the capture pin; the clock at it where the bench knows."""
        ...


def expires_at_its_rate(bench: TimerBench) -> None:
    """n expiries in n periods and a half; none after `stop`; anew after `start`."""
    expiries: list[int] = []
    line = bench.line("timer", lambda: expiries.append(1))
    for rate, count in ((100, 5), (1000, 20)):
        expiries.clear()
        bench.expect(f"timer tick start {rate}")
        bench.timer.start(rate, line)
        bench.wait((2 * count + 1) * 1_000_000_000 // (2 * rate), count)
        assert len(expiries) == count, f"{len(expiries)} expiries at {rate} Hz, expected {count}"
        bench.expect("timer tick stop")
        bench.timer.stop()
        bench.wait(3_000_000_000 // rate, 0)
        assert len(expiries) == count, "the timer ran on after stop()"


def captures_edges(bench: TimerBench) -> None:
    """(0, 0) before the first edge; count and clock after each; the line is pended; `start` clears."""
    edges: list[int] = []
    line = bench.line("capture", lambda: edges.append(1))
    bench.expect("capture pps start")
    bench.capture.start(line)
    assert bench.capture.captured() == (0, 0)
    last = 0
    for count in (1, 2, 3):
        at = bench.edge()
        captured = bench.capture.captured()
        assert captured[0] == count, f"{captured[0]} edges, expected {count}"
        assert captured[1] > last, f"clock {captured[1]} at edge {count}, after {last}"
        assert at is None or captured[1] == at, f"clock {captured[1]} at an edge at {at}"
        assert len(edges) == count
        last = captured[1]
    bench.expect("capture pps start")
    bench.capture.start()
    assert bench.capture.captured() == (0, 0)
    bench.edge()
    assert bench.capture.captured()[0] == 1
    assert len(edges) == 3, "a capture without a line pended one"


CHECKS: tuple[Callable[[TimerBench], None], ...] = (expires_at_its_rate, captures_edges)
