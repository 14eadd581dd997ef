"""Interrupt sources, their latches and what the two pins show (fact sheet section 3, 0x50 … 0x57).

Every source has a condition, decided at sample instants or by a FIFO access, and an assertion made of it
by the latch mode: non-latched follows the condition; a latch time holds the assertion that long from its
beginning and at least as long as the condition; latched holds it until its status register is read or an
interrupt reset comes, and at least as long as the condition. Data ready is an event, not a condition: it
lasts for a pulse in non-latched mode, or until the data are read.

All states are functions of what happened and the time asked for, so that nothing has to run while nobody
looks. `next_change` says when a pin would change by time alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum

from boards.chips.bmi160.register_map import INT_EN_0, INT_LATCH, INT_MAP_0, INT_MAP_1, INT_MAP_2

PULSE_NS = 312_500
"""Length of a non-latched data-ready pulse and of a pulse in edge mode, at most half a sample period."""

NON_LATCHED, LATCHED = 0x0, 0xF
LATCH_NS = (0, *(312_500 << code for code in range(14)))
"""Latch time of codes 0x1 … 0xE: 312.5 µs, doubling, 2.56 s."""


class Source(Enum):
    """(status byte, status bit, enable byte, enable bits, map bit for INT1, for INT2, in INT_MAP_1?)."""

    ANY_MOTION = (0, 0x04, 0, 0x07, 0x04, 0x04, False)
    NO_MOTION = (1, 0x80, 2, 0x07, 0x08, 0x08, False)
    HIGH_G = (1, 0x04, 1, 0x07, 0x02, 0x02, False)
    LOW_G = (1, 0x08, 1, 0x08, 0x01, 0x01, False)
    DATA_READY = (1, 0x10, 1, 0x10, 0x80, 0x08, True)
    FIFO_FULL = (1, 0x20, 1, 0x20, 0x20, 0x02, True)
    FIFO_WATERMARK = (1, 0x40, 1, 0x40, 0x40, 0x04, True)

    def enabled(self, registers: Sequence[int]) -> int:
        """The source's enable bits, 0 when it is off."""
        return registers[INT_EN_0 + self.value[2]] & self.value[3]

    def mapped(self, registers: Sequence[int], pin: int) -> bool:
        """Whether it drives INT1 (pin 0) or INT2 (pin 1)."""
        if self.value[6]:
            return bool(registers[INT_MAP_1] & self.value[4 + pin])
        return bool(registers[(INT_MAP_0, INT_MAP_2)[pin]] & self.value[4 + pin])


@dataclass(slots=True)
class _Latch:
    condition: bool = False
    since: int | None = None
    """When the assertion began (ns)."""
    latched: bool = False

    def active(self, time_ns: int, mode: int) -> bool:
        if self.condition or mode == NON_LATCHED or self.since is None:
            return self.condition
        return self.latched if mode == LATCHED else time_ns < self.since + LATCH_NS[mode]


@dataclass(slots=True)
class Interrupts:
    """State of all sources. `registers` are the chip's register values."""

    registers: Sequence[int]
    pulse_ns: int = PULSE_NS
    motion_detail: int = 0
    """Axis and sign of any-motion for INT_STATUS_2, of the last time it was asserted."""
    high_g_detail: int = 0
    """The same of high-g for INT_STATUS_3."""
    _latches: dict[Source, _Latch] = field(default_factory=lambda: {source: _Latch() for source in Source})

    def reset(self) -> None:
        """Clear every status, latch and pin (command, and soft reset)."""
        for source in Source:
            self._latches[source] = _Latch()
        self.motion_detail = self.high_g_detail = 0

    @property
    def mode(self) -> int:
        """The latch code in use."""
        return self.registers[INT_LATCH] & 0x0F

    def set_condition(self, source: Source, condition: bool, time_ns: int) -> None:
        """Tell whether the condition of a source holds from `time_ns` on."""
        latch = self._latches[source]
        if condition and not latch.condition and not latch.active(time_ns, self.mode):
            latch.since = time_ns
            latch.latched = True
        latch.condition = condition

    def event(self, source: Source, time_ns: int) -> None:
        """A source without a duration of its own fires (data ready)."""
        latch = self._latches[source]
        if not self.active(source, time_ns):
            latch.since = time_ns
            latch.latched = True

    def withdraw(self, source: Source) -> None:
        """End a non-latched assertion because its cause was served."""
        if self.mode == NON_LATCHED:
            self._latches[source] = _Latch()

    def disable(self, source: Source) -> None:
        """Forget a source that was switched off."""
        self._latches[source] = _Latch()

    def condition(self, source: Source) -> bool:
        """Whether a source's condition holds."""
        return self._latches[source].condition

    def active(self, source: Source, time_ns: int) -> bool:
        """Whether a source is asserted."""
        latch, mode = self._latches[source], self.mode
        if source is Source.DATA_READY and mode == NON_LATCHED:
            return latch.since is not None and time_ns < latch.since + self.pulse_ns
        return latch.active(time_ns, mode)

    def status(self, time_ns: int) -> tuple[int, int, int, int]:
        """The registers INT_STATUS_0 … 3."""
        status = [0, 0, 0, 0]
        for source in Source:
            if self.active(source, time_ns):
                status[source.value[0]] |= source.value[1]
        if status[0] & Source.ANY_MOTION.value[1]:
            status[2] = self.motion_detail
        if status[1] & Source.HIGH_G.value[1]:
            status[3] = self.high_g_detail
        return status[0], status[1], status[2], status[3]

    def status_read(self, byte: int) -> None:
        """A status register was read: it clears its latched bits whose condition is over."""
        if self.mode != LATCHED:
            return
        for source in Source:
            if source.value[0] == byte:
                self._latches[source].latched = False

    def asserted(self, pin: int, time_ns: int, edge_mode: bool) -> bool:
        """Whether a pin is at its active level."""
        for source in Source:
            if source.mapped(self.registers, pin):
                since = self._latches[source].since
                if edge_mode:
                    if since is not None and since <= time_ns < since + self.pulse_ns:
                        return True
                elif self.active(source, time_ns):
                    return True
        return False

    def next_change(self, time_ns: int) -> int | None:
        """The next time after `time_ns` at which an assertion or a pulse ends by itself (ns)."""
        mode = self.mode
        ends = []
        for latch in self._latches.values():
            if latch.since is not None:
                ends.append(latch.since + self.pulse_ns)
                if mode not in (NON_LATCHED, LATCHED):
                    ends.append(latch.since + LATCH_NS[mode])
        return min((end for end in ends if end > time_ns), default=None)
