"""One line of the emulated interrupt controller, with the figures that a schedulability report needs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from hal.emulated.virtual_time import FAR
from hal.interrupts import InterruptLine

if TYPE_CHECKING:
    from hal.emulated.cpu import EmulatedCpu


NEVER_YET: Final = -1


@dataclass(frozen=True)
class LineSpec:
    """What the board description says of a line. `priority`: lower is more urgent."""

    name: str
    priority: int
    deadline_ns: int | None = None
    stack_bytes: int = 0


class EmulatedLine:
    """An interrupt line or software task. Hardware calls `request`, firmware calls `pend`."""

    __slots__ = (
        "_cpu",
        "_others",
        "_others_ns",
        "_time",
        "above",
        "bit",
        "deadline_misses",
        "deadline_ns",
        "handler",
        "nested_ns",
        "open",
        "overruns",
        "pended_at",
        "repeats",
        "spec",
        "usual_ns",
        "worst_busy_ns",
        "worst_response_ns",
        "worst_start_ns",
    )

    def __init__(self, cpu: EmulatedCpu, spec: LineSpec, bit: int) -> None:
        self._cpu = cpu
        self._time = cpu.time
        self.spec = spec
        self.bit = bit
        self.above = 0
        """Bits of all more urgent lines."""
        self.open = 0
        """Those of them that are enabled: what may interrupt this line's handler."""
        self.deadline_ns = FAR if spec.deadline_ns is None else spec.deadline_ns
        self.handler: Callable[[], None] = _unattached
        self.pended_at = 0
        self.nested_ns = 0
        """What more urgent lines have taken of the activation at work."""
        self.overruns = 0
        self.deadline_misses = 0
        self.usual_ns = NEVER_YET
        """How long the handler took when it last began at once and was not interrupted."""
        self.repeats = 0
        """Activations that went just so, and are in no other figure."""
        self._others = 0
        self._others_ns = 0
        self.worst_busy_ns = 0
        self.worst_response_ns = 0
        self.worst_start_ns = 0

    @property
    def activations(self) -> int:
        """How often the handler has run."""
        return self._others + self.repeats

    @property
    def busy_ns(self) -> int:
        """Time in the handler, more urgent lines left out."""
        return self._others_ns + self.repeats * self.usual_ns

    def account(self, waited: int, took: int) -> None:
        """An activation unlike the one before: it began `waited` after the request and took `took` ns."""
        nested, self.nested_ns = self.nested_ns, 0
        response, busy = waited + took, took - nested
        self.worst_busy_ns = max(self.worst_busy_ns, busy)
        self.worst_start_ns = max(self.worst_start_ns, waited)
        self.worst_response_ns = max(self.worst_response_ns, response)
        self.deadline_misses += response > self.deadline_ns
        self._others += 1
        self._others_ns += busy
        if self._cpu.tracing:
            self._cpu.trace_activation(self.bit, took)
        elif not waited and not nested and took <= self.deadline_ns:
            self.expect(took)

    def expect(self, usual_ns: int) -> None:
        """From now on an undisturbed activation of this length is the ordinary one."""
        self._others += self.repeats
        self._others_ns += self.repeats * self.usual_ns
        self.repeats = 0
        self.usual_ns = usual_ns

    def request(self) -> None:
        """A piece of hardware asks for service, from an event or while some firmware operates it."""
        cpu = self._cpu
        bit = self.bit
        pending = cpu.pending
        if pending & bit:
            self.overruns += 1
            return
        cpu.pending = pending | bit
        time = self._time
        self.pended_at = now = time.now
        if cpu.parked:
            if bit & cpu.running.open:
                cpu.rouse()
        elif time.next_due > now:
            time.look_now()

    def pend(self) -> None:
        """The firmware asks for service; a more urgent line than the caller's runs before this returns."""
        cpu = self._cpu
        bit = self.bit
        pending = cpu.pending
        if pending & bit:
            self.overruns += 1
            return
        cpu.pending = pending | bit
        self.pended_at = self._time.now
        if bit & cpu.running.open:
            cpu.serve()

    def enable(self) -> None:
        """Let the line interrupt the processor."""
        self._cpu.set_enabled(self.bit, True)

    def disable(self) -> None:
        """Hold the line back; a request meanwhile stays pending."""
        self._cpu.set_enabled(self.bit, False)


def emulated_line(line: InterruptLine) -> EmulatedLine:
    """`line` as hardware sees it. Raises TypeError for a line that no emulated processor handed out."""
    if not isinstance(line, EmulatedLine):
        raise TypeError(
            f"{line!r} is not a line of an emulated processor; take one from EmulatedCpu.attach()"
        )
    return line


def _unattached() -> None:
    raise RuntimeError("interrupt line without a handler was enabled; attach one first")
