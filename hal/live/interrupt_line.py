"""One interrupt line of a live processor."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from hal.interrupts import LineFigures

if TYPE_CHECKING:
    from hal.live.cpu import LiveCpu


class LiveLine:
    """Implements `hal.interrupts.InterruptLine`; any thread may `pend` it.

    Handlers run in the firmware's own thread only: a request of the firmware itself is served before
    `pend` returns when the line is more urgent than what runs, any other one at the next safe point.
    """

    __slots__ = (
        "_cpu",
        "activations",
        "busy_ns",
        "deadline_ns",
        "deadlines_missed",
        "enabled",
        "handler",
        "name",
        "overruns",
        "pended_at",
        "pending",
        "priority",
        "worst_response_ns",
    )

    def __init__(self, cpu: LiveCpu, name: str, priority: int, deadline_ns: int | None) -> None:
        self._cpu = cpu
        self.name = name
        self.priority = priority
        self.deadline_ns = deadline_ns
        self.handler: Callable[[], None] = _unattached
        self.pending = False
        self.enabled = False
        self.pended_at = 0
        """By the host's monotonic clock."""
        self.activations = self.overruns = self.deadlines_missed = 0
        self.busy_ns = self.worst_response_ns = 0

    def pend(self) -> None:
        """Make the line pending; a second request before the handler has run counts as an overrun."""
        self._cpu.request(self)

    def note(self, end_ns: int, busy_ns: int) -> None:
        """The handler has run; `busy_ns` of the time was its own."""
        response = end_ns - self.pended_at
        self.activations += 1
        self.busy_ns += busy_ns
        self.worst_response_ns = max(self.worst_response_ns, response)
        self.deadlines_missed += self.deadline_ns is not None and response > self.deadline_ns

    def figures(self) -> LineFigures:
        """What this line has done."""
        return LineFigures(
            self.name, self.activations, self.busy_ns, self.worst_response_ns, self.deadlines_missed
        )

    def enable(self) -> None:
        """Let the line interrupt the processor."""
        self._cpu.set_enabled(self, True)

    def disable(self) -> None:
        """Hold the line back; a request meanwhile stays pending."""
        self._cpu.set_enabled(self, False)


def _unattached() -> None:
    raise RuntimeError("interrupt line without a handler was enabled; attach one first")
