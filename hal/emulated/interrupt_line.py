"""One line of the emulated interrupt controller, with the figures that a schedulability report needs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from hal.emulated.virtual_time import FAR
from hal.interrupts import InterruptLine

if TYPE_CHECKING:
    from hal.emulated.cpu import EmulatedCpu


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
        "above",
        "activations",
        "bit",
        "busy_ns",
        "deadline_misses",
        "deadline_ns",
        "handler",
        "notable_ns",
        "open",
        "overruns",
        "pended_at",
        "spec",
        "worst_busy_ns",
        "worst_response_ns",
        "worst_start_ns",
    )

    def __init__(self, cpu: EmulatedCpu, spec: LineSpec, bit: int) -> None:
        self._cpu = cpu
        self.spec = spec
        self.bit = bit
        self.above = 0
        """Bits of all more urgent lines."""
        self.open = 0
        """Those of them that are enabled: what may interrupt this line's handler."""
        self.deadline_ns = FAR if spec.deadline_ns is None else spec.deadline_ns
        self.handler: Callable[[], None] = _unattached
        self.pended_at = 0
        self.activations = 0
        self.overruns = 0
        self.deadline_misses = 0
        self.busy_ns = 0
        self.notable_ns = 0
        """A response that takes longer is the longest so far, or misses the deadline."""
        self.worst_busy_ns = 0
        self.worst_response_ns = 0
        self.worst_start_ns = 0

    def note(self, response: int, busy: int, waited: int) -> None:
        """An activation that took longer than any before in some respect (ns), or missed its deadline."""
        self.worst_busy_ns = max(self.worst_busy_ns, busy)
        self.worst_start_ns = max(self.worst_start_ns, waited)
        self.worst_response_ns = max(self.worst_response_ns, response)
        self.deadline_misses += response > self.deadline_ns
        self.notable_ns = min(self.worst_response_ns, self.deadline_ns)

    def request(self) -> None:
        """A piece of hardware asks for service, from an event or while some firmware operates it."""
        cpu = self._cpu
        bit = self.bit
        if cpu.pending & bit:
            self.overruns += 1
            return
        cpu.pending |= bit
        time = cpu.time
        self.pended_at = now = time.now
        if not cpu.parked:
            if time.next_due > now:
                time.look_now()
        elif bit & cpu.open_lines:
            cpu.rouse()

    def pend(self) -> None:
        """The firmware asks for service; a more urgent line than the caller's runs before this returns."""
        cpu = self._cpu
        bit = self.bit
        if cpu.pending & bit:
            self.overruns += 1
            return
        cpu.pending |= bit
        self.pended_at = cpu.time.now
        if bit & cpu.open_lines:
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
