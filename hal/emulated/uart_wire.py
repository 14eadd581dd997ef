"""One direction of a serial line, on virtual time.

The transmitter queues bytes; the line works them off back to back at the baud rate of the moment when they
were queued. Receivers are told at once what will come and when, so that a burst costs a few events instead
of one a byte. Only while a fault is at work that looks at each frame does the line go byte by byte.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable

from hal.emulated.alarm import Alarm
from hal.emulated.uart_bytes import NO_STOP_BIT, NOT_TAKEN, BrokenFrames, MissedBytes, SentBytes
from hal.emulated.uart_faces import LineFault, LineListener, UartPeer
from hal.emulated.uart_receiver import LateReceiver, LineReceiver, PeerReceiver
from hal.emulated.virtual_time import FAR, VirtualTime


class UartWire:
    """The line from one transmitter to all who listen."""

    def __init__(self, time: VirtualTime, baud: int, name: str = "uart", capacity: int | None = None) -> None:
        self.time = time
        self.name = name
        self.capacity = capacity
        """Room for bytes queued and not yet sent; None: any number."""
        self.baud = _checked(baud, name)
        self.forced_baud: int | None = None
        """The rate at which a transmitter with a fault really sends."""
        self.form: type[SentBytes] = SentBytes
        """How it frames its bytes."""
        self.bytes_sent = 0
        self._receivers: list[LineListener] = []
        self._followers: list[LineReceiver] = []
        self._queue: deque[SentBytes] = deque()
        self._end = 0
        self._line_ns = 0
        self._faults: list[LineFault] = []
        self._stepping = False
        self._to_step: deque[SentBytes] = deque()
        self._stepper = Alarm(time, self._step)

    # -- transmitter -------------------------------------------------------------------------------

    def send(self, data: Iterable[int]) -> int:
        """Queue bytes behind what is still being sent; returns how many found room."""
        return self._send(bytes(data))

    def _send(self, data: bytes) -> int:
        taken = len(data)
        now = self.time.now
        idle = self._end <= now
        room = self.capacity if idle else self.free
        if room is not None and taken > room:
            taken = room
            data = data[:taken]
        for fault in self._faults:
            data = fault.sent(data)
        if not data:
            return taken
        if idle:
            self._queue.clear()
            piece = self.form(data, now, 0, self.forced_baud or self.baud)
        else:
            piece = self._behind_the_queue(data)
        self._queue.append(piece)
        self._end = end = piece.end
        self._line_ns += end - piece.begin
        self.bytes_sent += len(data)
        if self._stepping:
            self._send_stepping(piece)
        else:
            for receiver in self._receivers:
                receiver.announce(piece)
        return taken

    def set_baud(self, baud: int) -> None:
        """Change the rate for the bytes that follow; what is queued goes at the rate it was queued with."""
        if baud != self.baud:
            self.baud = _checked(baud, self.name)
            for receiver in self._followers:
                receiver.rate_changed()

    @property
    def queued(self) -> int:
        """Bytes queued that have not been sent completely."""
        now = self.time.now
        if self._end <= now:
            return 0
        last = self._queue[-1]
        if last.start <= now:  # all that was queued before this run has been sent
            return last.first + len(last.data) - last.frames_ended(now)
        self._forget_sent()
        count = -self._queue[0].ended_by(now)
        for piece in self._queue:
            count += len(piece.data)
        return count

    @property
    def free(self) -> int | None:
        """Room for further bytes; None: any number."""
        if self.capacity is None or self._end <= self.time.now:
            return self.capacity
        free = self.capacity - self.queued
        return free if free > 0 else 0

    @property
    def busy_ns(self) -> int:
        """Time for which the line has carried bytes up to now."""
        return self._line_ns - max(0, self._end - self.time.now)

    @property
    def idle_from(self) -> int:
        """When everything queued will have been sent."""
        return self._end

    def abort(self) -> None:
        """The transmitter stops at once; the byte under way is lost with everything behind it."""
        self._lose_from(self._frame_under_way()[0])
        self._line_ns = self.busy_ns
        self._end = self.time.now
        self._queue.clear()
        self._to_step.clear()

    # -- receivers ---------------------------------------------------------------------------------

    def connect(self, peer: UartPeer, rate_of: UartWire | None = None) -> None:
        """Let `peer` listen from now on.

        `rate_of`: the line that the same chip drives, when both directions of its port share one baud rate;
        without it the peer understands every rate.
        """
        baud = None if rate_of is None else lambda: rate_of.baud
        receiver = PeerReceiver(self.time, peer, baud)
        if rate_of is not None:
            rate_of._followers.append(receiver)
        self.attach(receiver)

    def connect_late(self) -> LateReceiver:
        """A listener that is not called but asked."""
        receiver = LateReceiver(self.time)
        self.attach(receiver)
        return receiver

    def attach(self, receiver: LineListener) -> None:
        """Connect a receiver; it hears what is sent from now on."""
        self._receivers.append(receiver)

    # -- faults ------------------------------------------------------------------------------------

    def begin_fault(self, fault: LineFault) -> None:
        """From now on `fault` is at work."""
        self._faults.append(fault)
        if fault.frame_by_frame and not self._stepping:
            self._go_step_by_step()
        if fault.breaks_frame:
            begin, value = self._frame_under_way()
            self._lose_from(begin)
            if value is not None:
                fault.frame(value)

    def end_fault(self, fault: LineFault) -> None:
        """`fault` has passed. The line goes on byte by byte until it is idle."""
        self._faults.remove(fault)

    def inject(self, data: bytes) -> int:
        """Put bytes on the line that no transmitter sent (noise); returns when they end."""
        noise = SentBytes(data, self.time.now, 0, self.baud)
        for receiver in self._receivers:
            receiver.announce(noise)
        return noise.end

    # -- replay ------------------------------------------------------------------------------------

    def relay(self, piece: SentBytes) -> None:
        """Tell the receivers now of bytes that were on a line elsewhere, at the instants they had there."""
        self.bytes_sent += len(piece.data)
        self._line_ns += piece.end - piece.begin
        self._end = max(self._end, piece.end)
        for receiver in self._receivers:
            receiver.announce(piece)

    def retract(self, begin_from: int) -> None:
        """Bytes relayed that begin at `begin_from` or later do not come after all."""
        self._lose_from(begin_from)

    # ----------------------------------------------------------------------------------------------

    def _behind_the_queue(self, data: bytes) -> SentBytes:
        """Where the line carries these bytes: behind what is still being sent."""
        baud = self.forced_baud or self.baud
        self._forget_sent()
        last = self._queue[-1]
        if last.baud == baud and type(last) is self.form:
            return self.form(data, last.start, last.first + len(last.data), baud)
        return self.form(data, self._end, 0, baud)

    def _send_stepping(self, piece: SentBytes) -> None:
        """The same while faults look at each byte, until the line has been idle without them."""
        if len(self._queue) == 1 and not any(fault.frame_by_frame for fault in self._faults):
            self._stepping = False
            for receiver in self._receivers:
                receiver.announce(piece)
        else:
            self._to_step.append(piece)
            self._stepper.by(self._to_step[0].begin)

    def _forget_sent(self) -> None:
        queue = self._queue
        now = self.time.now
        while queue and queue[0].end <= now:
            queue.popleft()

    def _frame_under_way(self) -> tuple[int, int | None]:
        """Beginning and value of the byte that is on the line, or (now, None)."""
        self._forget_sent()
        now = self.time.now
        if self._queue:
            piece = self._queue[0]
            ended = piece.ended_by(now)
            if piece.begun_before(now) > ended:
                return piece.begin_of(ended), piece.data[ended]
        return now, None

    def _lose_from(self, begin: int) -> None:
        for receiver in self._receivers:
            receiver.forget(begin)

    def _go_step_by_step(self) -> None:
        """Take back every byte that has not begun; each is announced when it begins."""
        now = self.time.now
        self._stepping = True
        self._forget_sent()
        for piece in self._queue:
            rest = piece.split(piece.begun_before(now))[1]
            if rest.data:
                self._to_step.append(rest)
        self._lose_from(now)
        if self._to_step:
            self._stepper.by(self._to_step[0].begin)

    def _step(self) -> int:
        """Send the byte that begins now through the faults."""
        waiting = self._to_step
        while waiting and waiting[0].begin <= self.time.now:
            piece, rest = waiting[0].split(1)
            if rest.data:
                waiting[0] = rest
            else:
                waiting.popleft()
            value = self._disturbed(piece.data[0])
            if value is not None:
                if type(piece) is SentBytes:
                    piece = _form_of(value)(piece.data, piece.start, piece.first, piece.baud)
                piece.data = bytes((value & 0xFF,))
                for receiver in self._receivers:
                    receiver.announce(piece)
        return waiting[0].begin if waiting else FAR

    def _disturbed(self, value: int) -> int | None:
        broken = 0
        for fault in self._faults:
            if fault.frame_by_frame:
                seen = fault.frame(value)
                if seen is None:
                    return None
                broken |= seen & ~0xFF
                value = seen & 0xFF
        return value | broken


def _form_of(value: int) -> type[SentBytes]:
    """Of a byte that has been through the faults."""
    if value & NOT_TAKEN:
        return MissedBytes
    return BrokenFrames if value & NO_STOP_BIT else SentBytes


def _checked(baud: int, name: str) -> int:
    if baud <= 0:
        raise ValueError(f"baud rate {baud} of {name!r}; it must be positive, e.g. 9600")
    return baud
