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

from boards.chips.bmi160.register_map import INT_EN_0, INT_LATCH, INT_MAP_0, INT_MAP_1, INT_MAP_2

PULSE_NS = 312_500
"""Length of a non-latched data-ready pulse and of a pulse in edge mode, at most half a sample period."""

NON_LATCHED, LATCHED = 0x0, 0xF
LATCH_NS = (0, *(312_500 << code for code in range(14)))
"""Latch time of codes 0x1 … 0xE: 312.5 µs, doubling, 2.56 s."""


@dataclass(frozen=True, slots=True, eq=False)
class SourceBits:
    """Where the bits of one interrupt source lie."""

    status_byte: int
    status_bit: int
    enable_register: int
    enable_bits: int
    map_registers: tuple[int, int]
    """For INT1 and INT2."""
    map_bits: tuple[int, int]

    def enabled(self, registers: Sequence[int]) -> int:
        """The source's enable bits, 0 when it is off."""
        return registers[self.enable_register] & self.enable_bits

    def mapped(self, registers: Sequence[int], pin: int) -> bool:
        """Whether it drives INT1 (pin 0) or INT2 (pin 1)."""
        return bool(registers[self.map_registers[pin]] & self.map_bits[pin])


_FEATURES = (INT_MAP_0, INT_MAP_2)
_DATA = (INT_MAP_1, INT_MAP_1)


class Source:
    """The interrupt sources."""

    ANY_MOTION = SourceBits(0, 0x04, INT_EN_0, 0x07, _FEATURES, (0x04, 0x04))
    NO_MOTION = SourceBits(1, 0x80, INT_EN_0 + 2, 0x07, _FEATURES, (0x08, 0x08))
    HIGH_G = SourceBits(1, 0x04, INT_EN_0 + 1, 0x07, _FEATURES, (0x02, 0x02))
    LOW_G = SourceBits(1, 0x08, INT_EN_0 + 1, 0x08, _FEATURES, (0x01, 0x01))
    DATA_READY = SourceBits(1, 0x10, INT_EN_0 + 1, 0x10, _DATA, (0x80, 0x08))
    FIFO_FULL = SourceBits(1, 0x20, INT_EN_0 + 1, 0x20, _DATA, (0x20, 0x02))
    FIFO_WATERMARK = SourceBits(1, 0x40, INT_EN_0 + 1, 0x40, _DATA, (0x40, 0x04))


SOURCES = (
    Source.ANY_MOTION,
    Source.NO_MOTION,
    Source.HIGH_G,
    Source.LOW_G,
    Source.DATA_READY,
    Source.FIFO_FULL,
    Source.FIFO_WATERMARK,
)


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
    _latches: dict[SourceBits, _Latch] = field(
        default_factory=lambda: {source: _Latch() for source in SOURCES}
    )

    def reset(self) -> None:
        """Clear every status, latch and pin (command, and soft reset)."""
        for source in SOURCES:
            self._latches[source] = _Latch()
        self.motion_detail = self.high_g_detail = 0

    @property
    def mode(self) -> int:
        """The latch code in use."""
        return self.registers[INT_LATCH] & 0x0F

    def set_condition(self, source: SourceBits, condition: bool, time_ns: int) -> None:
        """Tell whether the condition of a source holds from `time_ns` on."""
        latch = self._latches[source]
        if condition and not latch.condition and not latch.active(time_ns, self.mode):
            latch.since = time_ns
            latch.latched = True
        latch.condition = condition

    def event(self, source: SourceBits, time_ns: int) -> None:
        """A source without a duration of its own fires (data ready)."""
        latch = self._latches[source]
        if not self.active(source, time_ns):
            latch.since = time_ns
            latch.latched = True

    def withdraw(self, source: SourceBits) -> None:
        """End a non-latched assertion because its cause was served."""
        if self.mode == NON_LATCHED:
            self._latches[source] = _Latch()

    def disable(self, source: SourceBits) -> None:
        """Forget a source that was switched off."""
        self._latches[source] = _Latch()

    def condition(self, source: SourceBits) -> bool:
        """Whether a source's condition holds."""
        return self._latches[source].condition

    def active(self, source: SourceBits, time_ns: int) -> bool:
        """Whether a source is asserted."""
        latch, mode = self._latches[source], self.mode
        if source is Source.DATA_READY and mode == NON_LATCHED:
            return latch.since is not None and time_ns < latch.since + self.pulse_ns
        return latch.active(time_ns, mode)

    def status(self, time_ns: int) -> tuple[int, int, int, int]:
        """The registers INT_STATUS_0 … 3."""
        status = [0, 0, 0, 0]
        for source in SOURCES:
            if self.active(source, time_ns):
                status[source.status_byte] |= source.status_bit
        if status[0] & Source.ANY_MOTION.status_bit:
            status[2] = self.motion_detail
        if status[1] & Source.HIGH_G.status_bit:
            status[3] = self.high_g_detail
        return status[0], status[1], status[2], status[3]

    def status_read(self, byte: int) -> None:
        """A status register was read: it clears its latched bits whose condition is over."""
        if self.mode != LATCHED:
            return
        for source in SOURCES:
            if source.status_byte == byte:
                self._latches[source].latched = False

    def asserted(self, pin: int, time_ns: int, edge_mode: bool) -> bool:
        """Whether a pin is at its active level."""
        for source in SOURCES:
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
