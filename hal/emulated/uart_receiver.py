"""The receiving end of a serial line: what arrives there and when.

While the receiver's rate agrees with the line's, arrivals are the bytes sent, known as soon as they are
queued. Otherwise the line is sampled bit by bit at the receiver's rate (`uart_bytes.sample`), and so is
what is under way when a receiver changes its rate; when the line falls idle, it is in step again.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

from hal.emulated.alarm import Alarm
from hal.emulated.uart_bytes import FRAME, SampledByte, SentBytes, rates_agree, sample
from hal.emulated.uart_faces import UartPeer
from hal.emulated.virtual_time import FAR, VirtualTime


class LineReceiver:
    """Turns what is announced on a line into arrivals.

    `baud`: tells the receiver's rate now; None: it understands whatever comes. `last_end`: when the last
    byte taken had ended.
    """

    def __init__(self, time: VirtualTime, baud: Callable[[], int] | None) -> None:
        self._time = time
        self._baud = baud
        self.arrivals: deque[SentBytes | SampledByte] = deque()
        self._line: deque[SentBytes] = deque()
        self._sampled = False
        self._ready_at = 0
        self.last_end = 0
        self._alarm = Alarm(time, self._due)

    def announce(self, sent: SentBytes) -> None:
        """These bytes will be on the line, behind all that were announced before."""
        now = self._time.now
        line = self._line
        while line and line[0].end <= now and not self._sampled:
            line.popleft()
        if self._sampled and not self._under_way(now):
            self._sampled = False
            line.clear()
        line.append(sent)
        if not self._sampled and (self._baud is None or rates_agree(sent.baud, self._baud())):
            self.arrivals.append(sent)
        else:
            self._sample(now, max(now, sent.begin) if self._sampled else now)
        self._alarm.by(self._next_instant())

    def forget(self, begin_from: int) -> None:
        """Bytes whose start bit lies at `begin_from` or later will not come after all."""
        line = self._line
        while line and line[-1].begin >= begin_from:
            line.pop()
        if line:
            line[-1] = line[-1].split(line[-1].begun_before(begin_from))[0]
        if self._sampled:
            now = self._time.now
            self._sample(now, now)
        else:
            self._cut_arrivals(begin_from)
        self._alarm.by(self._next_instant())

    def rate_changed(self) -> None:
        """The receiver starts anew at another rate, in the middle of what is on the line."""
        now = self._time.now
        if self._line and self._line[-1].end > now:
            self._ready_at = now
            self._sample(now, now)
            self._alarm.by(self._next_instant())

    def take(self) -> tuple[bytes, int]:
        """What has arrived by now and was not taken yet, and the framing errors in it."""
        arrivals = self.arrivals
        if not arrivals:
            return b"", 0
        now = self._time.now
        taken: list[bytes] = []
        errors = 0
        while arrivals and arrivals[0].end <= now:
            batch = arrivals.popleft()
            self.last_end = batch.end
            taken.append(batch.taken)
            errors += batch.errors
        if arrivals and (count := arrivals[0].ended_by(now)):
            head = arrivals[0]
            assert isinstance(head, SentBytes)
            whole, arrivals[0] = head.split(count)
            self.last_end = whole.end
            taken.append(whole.taken)
            errors += whole.errors
        self._ready_at = max(self._ready_at, self.last_end)
        return b"".join(taken), errors

    def _next_instant(self) -> int:
        """When the receiver next has something to do; FAR when nothing is under way."""
        raise NotImplementedError

    def _due(self) -> int:
        """That instant has come, or an earlier one; returns the next."""
        raise NotImplementedError

    def _under_way(self, now: int) -> bool:
        """Whether the line is at work or a byte is being received."""
        arrivals = self.arrivals
        return bool((self._line and self._line[-1].end > now) or (arrivals and arrivals[-1].end > now))

    def _cut_arrivals(self, begin_from: int) -> None:
        arrivals = self.arrivals
        while arrivals and arrivals[-1].begin >= begin_from:
            arrivals.pop()
        if arrivals and isinstance(arrivals[-1], SentBytes):
            arrivals[-1] = arrivals[-1].split(arrivals[-1].begun_before(begin_from))[0]

    def _sample(self, now: int, known_to: int) -> None:
        """Sample what has not arrived yet; what ends by `known_to` has been sampled and stays."""
        assert self._baud is not None
        self._sampled = True
        arrivals = self.arrivals
        while arrivals and arrivals[-1].end > known_to:
            last = arrivals.pop()
            if isinstance(last, SentBytes) and (count := last.ended_by(known_to)):
                arrivals.append(last.split(count)[0])
        from_ns = max(self._ready_at, arrivals[-1].end) if arrivals else self._ready_at
        baud = self._baud()
        line = self._line
        done = min(from_ns, now)
        while line and (line[0].end <= done or line[0].end <= now - 2 * FRAME // baud):
            line.popleft()
        ahead: list[SentBytes] = []
        for piece in reversed(line):
            if piece.end <= from_ns:
                break
            ahead.append(piece)
        arrivals.extend(sample(ahead[::-1], baud, from_ns))


class LateReceiver(LineReceiver):
    """Keeps what was sent until it is asked: for listeners in no hurry, without an event a piece.

    It understands every rate.
    """

    def __init__(self, time: VirtualTime) -> None:
        super().__init__(time, None)

    def announce(self, sent: SentBytes) -> None:
        """These bytes will be on the line."""
        self.arrivals.append(sent)

    def forget(self, begin_from: int) -> None:
        """Bytes whose start bit lies at `begin_from` or later will not come after all."""
        self._cut_arrivals(begin_from)

    def pieces(self) -> list[tuple[bytes, int, int]]:
        """(bytes, end of the last one in ns, baud) of every piece that has ended by now, each given once."""
        arrivals, now = self.arrivals, self._time.now
        ended = []
        while arrivals and arrivals[0].end <= now:
            piece = arrivals.popleft()
            assert isinstance(piece, SentBytes)
            ended.append((piece.data, piece.end, piece.baud))
        return ended

    def _next_instant(self) -> int:
        return FAR


class PeerReceiver(LineReceiver):
    """Hands a peer one chunk for each piece that was sent, at the end of the piece."""

    def __init__(self, time: VirtualTime, peer: UartPeer, baud: Callable[[], int] | None) -> None:
        super().__init__(time, baud)
        self.peer = peer

    def _next_instant(self) -> int:
        return self.arrivals[0].end if self.arrivals else FAR

    def _due(self) -> int:
        if self.arrivals and self.arrivals[0].end <= self._time.now:
            data, _errors = self.take()
            self.peer.receive(data, self._time.now)
        return self._next_instant()
