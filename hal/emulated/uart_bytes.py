"""Bytes on a serial line, with the instants of their edges.

A frame has 10 bits: start (low), 8 data bits from the least significant on, stop (high). Bytes sent back to
back form a run; frame n of a run that starts at t₀ begins at t₀ + ⌊10·n·10⁹ / baud⌋ and ends where the
next begins, so that nothing is rounded twice (fact sheet, section 3). Faults send other forms (`FORMS`).
"""

from __future__ import annotations

from collections import deque
from typing import Final, Self

from hal.emulated.virtual_time import SECOND

FRAME_BITS = 10
FRAME = FRAME_BITS * SECOND
NO_STOP_BIT = 0x100
"""Of a byte on its way: its stop bit will be low."""
NOT_TAKEN = 0x200
"""The same: the port will not take it in time."""


class SentBytes:
    """A piece of a run: `data` are its frames `first`, `first` + 1, …

    `begin`: falling edge of the first start bit; `end`: end of the last stop bit.
    """

    __slots__ = ("baud", "begin", "data", "end", "first", "start")
    form = 0
    """What it is in a capture, see `FORMS`."""
    frame_bits = FRAME_BITS
    frame = FRAME
    """The same, in bit · ns/s."""

    def __init__(self, data: bytes, start: int, first: int, baud: int) -> None:
        self.data = data
        self.start = start
        self.first = first
        self.baud = baud
        frame = self.frame
        self.begin = start + first * frame // baud if first else start
        self.end = start + (first + len(data)) * frame // baud

    @property
    def taken(self) -> bytes:
        """What a port at the right rate takes of it."""
        return self.data

    @property
    def errors(self) -> int:
        """How many framing errors and overruns that port counts: none here."""
        return 0

    def begin_of(self, index: int) -> int:
        """Falling edge of the start bit of one byte."""
        return self.start + (self.first + index) * self.frame // self.baud

    def end_of(self, index: int) -> int:
        """End of the stop bit of one byte."""
        return self.start + (self.first + index + 1) * self.frame // self.baud

    def frames_ended(self, time_ns: int) -> int:
        """How many frames of a run without end would have ended at `time_ns`, not before `start`."""
        return ((time_ns - self.start + 1) * self.baud - 1) // self.frame

    def ended_by(self, time_ns: int) -> int:
        """How many of the bytes have ended at `time_ns`."""
        frames = self.frames_ended(time_ns) - self.first
        return max(0, min(frames, len(self.data)))

    def begun_before(self, time_ns: int) -> int:
        """How many of the bytes began before `time_ns`."""
        frames = -(-(time_ns - self.start) * self.baud // self.frame) - self.first
        return max(0, min(frames, len(self.data)))

    def split(self, count: int) -> tuple[Self, Self]:
        """The first `count` bytes and the others."""
        kind = type(self)
        return (
            kind(self.data[:count], self.start, self.first, self.baud),
            kind(self.data[count:], self.start, self.first + count, self.baud),
        )

    def level_at(self, time_ns: int) -> bool:
        """Level of the line at an instant between `begin` and `end`."""
        bit = ((time_ns - self.start + 1) * self.baud - 1) // SECOND
        return self._level_of(bit - self.frame_bits * self.first)

    def falling_edge(self, from_ns: int) -> int | None:
        """The first change from high to low at or after `from_ns`."""
        offset = self.frame_bits * self.first
        bit = max(0, -(-(from_ns - self.start) * self.baud // SECOND) - offset)
        for index in range(bit, self.frame_bits * len(self.data)):
            if not self._level_of(index) and (index == 0 or self._level_of(index - 1)):
                return self.start + (offset + index) * SECOND // self.baud
        return None

    def _level_of(self, bit: int) -> bool:
        frame, position = divmod(bit, self.frame_bits)
        if position == 0:
            return False
        return position > 8 or bool(self.data[frame] >> (position - 1) & 1)


class BrokenFrames(SentBytes):
    """Their stop bits are low."""

    __slots__ = ()
    form = 1

    @property
    def errors(self) -> int:
        """Each has its framing error."""
        return len(self.data)

    def _level_of(self, bit: int) -> bool:
        return bit % FRAME_BITS != FRAME_BITS - 1 and super()._level_of(bit)


class ParityFrames(SentBytes):
    """With a bit of even parity before the stop bit: eleven bits a frame.

    A port without parity takes that bit for the stop bit, and the stop bit for the line at rest.
    """

    __slots__ = ()
    form = 2
    frame_bits = FRAME_BITS + 1
    frame = (FRAME_BITS + 1) * SECOND

    @property
    def errors(self) -> int:
        """A framing error for each low parity bit."""
        return even_bytes(self.data)

    def _level_of(self, bit: int) -> bool:
        frame, position = divmod(bit, self.frame_bits)
        if position == FRAME_BITS - 1:
            return bool(self.data[frame].bit_count() & 1)
        return super()._level_of(bit)


class MissedBytes(SentBytes):
    """They come before the port has taken the ones before, and are lost to it."""

    __slots__ = ()
    form = 3

    @property
    def taken(self) -> bytes:
        """Nothing."""
        return b""

    @property
    def errors(self) -> int:
        """An overrun each."""
        return len(self.data)


FORMS: Final[tuple[type[SentBytes], ...]] = (SentBytes, BrokenFrames, ParityFrames, MissedBytes)


def even_bytes(data: bytes) -> int:
    """How many bytes have an even number of ones."""
    return sum(value.bit_count() % 2 == 0 for value in data)


class SampledByte:
    """One byte as a receiver found it that sampled the line on its own clock. `end`: when it sampled the
    stop bit."""

    __slots__ = ("begin", "data", "end", "errors", "taken")

    def __init__(self, value: int, begin: int, end: int, framing_error: bool) -> None:
        self.data = self.taken = bytes((value,))
        self.begin = begin
        self.end = end
        self.errors = int(framing_error)

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
    ahead = deque(line)
    while (edge := _falling_edge(ahead, from_ns)) is not None:
        samples = [_level(ahead, edge + (2 * k + 1) * SECOND // (2 * baud)) for k in range(FRAME_BITS)]
        if samples[0]:
            from_ns = edge + 1
            continue
        value = sum(samples[k + 1] << k for k in range(8))
        from_ns = edge + 19 * SECOND // (2 * baud)
        found.append(SampledByte(value, edge, from_ns, not samples[9]))
    return found


def _falling_edge(ahead: deque[SentBytes], from_ns: int) -> int | None:
    """Pieces that end by `from_ns` are dropped."""
    while ahead and ahead[0].end <= from_ns:
        ahead.popleft()
    for piece in ahead:
        edge = piece.falling_edge(from_ns)
        if edge is not None:
            return edge
    return None


def _level(ahead: deque[SentBytes], time_ns: int) -> bool:
    for piece in ahead:
        if piece.begin > time_ns:
            break
        if piece.begin <= time_ns < piece.end:
            return piece.level_at(time_ns)
    return True
