"""Bytes on a serial line, with the instants of their edges.

A frame has 10 bits: start (low), 8 data bits from the least significant on, stop (high). Bytes sent back to
back form a run; frame n of a run that starts at t₀ begins at t₀ + ⌊10·n·10⁹ / baud⌋ and ends where the
next begins, so that nothing is rounded twice (fact sheet, section 3).
"""

from __future__ import annotations

from hal.emulated.virtual_time import SECOND

FRAME_BITS = 10
FRAME = FRAME_BITS * SECOND
NO_STOP_BIT = 0x100
"""Of a byte on its way: its stop bit will be low."""


class SentBytes:
    """A piece of a run: `data` are its frames `first`, `first` + 1, …

    `begin`: falling edge of the first start bit; `end`: end of the last stop bit.
    """

    __slots__ = ("baud", "begin", "data", "end", "first", "start")

    def __init__(self, data: bytes, start: int, first: int, baud: int) -> None:
        self.data = data
        self.start = start
        self.first = first
        self.baud = baud
        self.begin = start + first * FRAME // baud if first else start
        self.end = start + (first + len(data)) * FRAME // baud

    @property
    def framing_errors(self) -> int:
        """None here: what a receiver at the right rate makes of a run."""
        return 0

    def begin_of(self, index: int) -> int:
        """Falling edge of the start bit of one byte."""
        return self.start + (self.first + index) * FRAME // self.baud

    def end_of(self, index: int) -> int:
        """End of the stop bit of one byte."""
        return self.start + (self.first + index + 1) * FRAME // self.baud

    def frames_ended(self, time_ns: int) -> int:
        """How many frames of a run without end would have ended at `time_ns`, not before `start`."""
        return ((time_ns - self.start + 1) * self.baud - 1) // FRAME

    def ended_by(self, time_ns: int) -> int:
        """How many of the bytes have ended at `time_ns`."""
        frames = self.frames_ended(time_ns) - self.first
        return max(0, min(frames, len(self.data)))

    def begun_before(self, time_ns: int) -> int:
        """How many of the bytes began before `time_ns`."""
        frames = -(-(time_ns - self.start) * self.baud // FRAME) - self.first
        return max(0, min(frames, len(self.data)))

    def split(self, count: int) -> tuple[SentBytes, SentBytes]:
        """The first `count` bytes and the others."""
        return (
            SentBytes(self.data[:count], self.start, self.first, self.baud),
            SentBytes(self.data[count:], self.start, self.first + count, self.baud),
        )

    def level_at(self, time_ns: int) -> bool:
        """Level of the line at an instant between `begin` and `end`."""
        bit = ((time_ns - self.start + 1) * self.baud - 1) // SECOND
        return self._level_of(bit - FRAME_BITS * self.first)

    def falling_edge(self, from_ns: int) -> int | None:
        """The first change from high to low at or after `from_ns`."""
        offset = FRAME_BITS * self.first
        bit = max(0, -(-(from_ns - self.start) * self.baud // SECOND) - offset)
        for index in range(bit, FRAME_BITS * len(self.data)):
            if not self._level_of(index) and (index == 0 or self._level_of(index - 1)):
                return self.start + (offset + index) * SECOND // self.baud
        return None

    def _level_of(self, bit: int) -> bool:
        frame, position = divmod(bit, FRAME_BITS)
        if position == 0:
            return False
        return position == FRAME_BITS - 1 or bool(self.data[frame] >> (position - 1) & 1)


class BrokenFrame(SentBytes):
    """One byte whose stop bit is low."""

    __slots__ = ()

    @property
    def framing_errors(self) -> int:
        """Its own."""
        return 1

    def split(self, count: int) -> tuple[SentBytes, SentBytes]:
        """The first `count` bytes and the others."""
        whole, rest = super().split(count)
        return (self, rest) if count else (whole, self)

    def _level_of(self, bit: int) -> bool:
        return bit != FRAME_BITS - 1 and super()._level_of(bit)


class SampledByte:
    """One byte as a receiver found it that sampled the line on its own clock. `end`: when it sampled the
    stop bit."""

    __slots__ = ("begin", "data", "end", "framing_errors")

    def __init__(self, value: int, begin: int, end: int, framing_error: bool) -> None:
        self.data = bytes((value,))
        self.begin = begin
        self.end = end
        self.framing_errors = int(framing_error)

    def end_of(self, _index: int) -> int:
        """End of the byte."""
        return self.end

    def ended_by(self, time_ns: int) -> int:
        """Whether it has ended at `time_ns` (0 or 1)."""
        return int(self.end <= time_ns)


def rates_agree(sent_baud: int, sampled_baud: int) -> bool:
    """Whether a receiver at `sampled_baud` gets every byte right of a line at `sent_baud`.

    It synchronises on each start bit and samples the stop bit 9.5 of its own bits later, which must lie
    within the tenth bit sent: 9·T_sent < 9.5·T_sampled < 10·T_sent.
    """
    return 18 * sampled_baud < 19 * sent_baud < 20 * sampled_baud


def sample(line: list[SentBytes], baud: int, from_ns: int) -> list[SampledByte]:
    """What a receiver makes of a line that it samples at `baud`, looking for a start bit from `from_ns` on.

    A falling edge starts a byte when the line is still low half a bit later; the bits are sampled in their
    middle; a low stop bit is a framing error, after which the next falling edge counts. Between the pieces
    of `line`, which are in order of time, the line is high.
    """
    found: list[SampledByte] = []
    while (edge := _falling_edge(line, from_ns)) is not None:
        samples = [_level(line, edge + (2 * k + 1) * SECOND // (2 * baud)) for k in range(FRAME_BITS)]
        if samples[0]:
            from_ns = edge + 1
            continue
        value = sum(samples[k + 1] << k for k in range(8))
        from_ns = edge + 19 * SECOND // (2 * baud)
        found.append(SampledByte(value, edge, from_ns, not samples[9]))
    return found


def _falling_edge(line: list[SentBytes], from_ns: int) -> int | None:
    for piece in line:
        if piece.end > from_ns:
            edge = piece.falling_edge(from_ns)
            if edge is not None:
                return edge
    return None


def _level(line: list[SentBytes], time_ns: int) -> bool:
    for piece in line:
        if piece.begin <= time_ns < piece.end:
            return piece.level_at(time_ns)
    return True
