"""Pins in real time: the modem lines of a serial port.

    outputs     RTS, DTR            inputs      CTS, DSR, RI, CD

A modem line is inverted by the level shifter of an RS-232 port, and by nothing in a USB adapter with TTL
pins, where *set* means low; `inverted` says which. Edges are found by looking, `LOOK_NS` apart at best: a
pulse shorter than that may be missed.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from time import monotonic_ns
from typing import Protocol

from hal.interrupts import InterruptLine
from hal.live.alarms import Alarm
from hal.live.cpu import LiveCpu
from hal.live.serial_link import SerialLink
from hal.pins import Edge

LOOK_NS = 1_000_000


class LevelSource(Protocol):
    """Something that has a level."""

    def level(self) -> bool:
        """The level now."""
        ...


class ModemOutputLine(Enum):
    """Lines that a computer drives."""

    RTS = "rts"
    DTR = "dtr"


class ModemInputLine(Enum):
    """Lines that a computer reads."""

    CTS = "cts"
    DSR = "dsr"
    RI = "ri"
    CD = "cd"


class EdgeWatch:
    """Looks at a level at safe points and tells of its edges."""

    def __init__(self, cpu: LiveCpu, source: LevelSource, period_ns: int = LOOK_NS) -> None:
        self._cpu = cpu
        self._source = source
        self._period_ns = period_ns
        self._alarm: Alarm | None = None
        self._level = False
        self._edge = Edge.BOTH
        self._tell: Callable[[int], None] | None = None

    def begin(self, edge: Edge, tell: Callable[[int], None]) -> None:
        """Call `tell(clock_ns)` at every such edge from now on, in place of what was to be told before."""
        self.end()
        self._edge = edge
        self._tell = tell
        self._level = self._source.level()
        self._alarm = self._cpu.alarm_at(monotonic_ns() + self._period_ns, self._look_again)

    def end(self) -> None:
        """Look no more."""
        self._tell = None
        if self._alarm is not None:
            self._alarm.cancel()
            self._alarm = None

    def look(self) -> None:
        """Look now."""
        level = self._source.level()
        if level == self._level or self._tell is None:
            return
        self._level = level
        if self._edge is Edge.BOTH or self._edge is (Edge.RISING if level else Edge.FALLING):
            self._tell(self._cpu.clock_at(monotonic_ns()))

    def _look_again(self, due_ns: int) -> int:
        self.look()
        # Looks that were missed are not made up for: they would all see the same level.
        return max(due_ns + self._period_ns, monotonic_ns())


class ModemOutput:
    """Implements `hal.pins.OutputPin` on RTS or DTR. While the port is away the level is remembered."""

    def __init__(self, cpu: LiveCpu, link: SerialLink, line: ModemOutputLine, inverted: bool = False) -> None:
        self._cpu = cpu
        self._link = link
        self._line = line
        self._inverted = inverted

    def set(self, level: bool) -> None:
        """Drive the electrical level."""
        self._link.set_modem_line(self._line.value, level != self._inverted)
        self._cpu.safe_point()


class ModemInput:
    """Implements `hal.pins.InputPin` on CTS, DSR, RI or CD; the last level known while the port is away."""

    def __init__(
        self,
        cpu: LiveCpu,
        link: SerialLink,
        line: ModemInputLine,
        inverted: bool = False,
        period_ns: int = LOOK_NS,
    ) -> None:
        self._cpu = cpu
        self._link = link
        self._line = line
        self._inverted = inverted
        self._last = False
        self._watch = EdgeWatch(cpu, self, period_ns)
        cpu.reset_hooks.append(self._watch.end)

    def level(self) -> bool:
        """The level, without giving interrupts a chance."""
        state = self._link.modem_line(self._line.value)
        if state is not None:
            self._last = state != self._inverted
        return self._last

    def read(self) -> bool:
        """The electrical level now."""
        self._cpu.safe_point()
        return self.level()

    def interrupt_on(self, edge: Edge, line: InterruptLine) -> None:
        """Pend `line` at every such edge."""
        self._watch.begin(edge, lambda _clock_ns: line.pend())
