"""A real receiver's place on the board: what it says goes onto the board's line, what it hears to its port.

The line into the board always has the rate of the board's own UART, as the port has: where receiver and
board disagree about it, the port's hardware has garbled the bytes already.
"""

from __future__ import annotations

from collections import deque

from boards.assembly import AssembledBoard
from boards.chips.world import GnssWorld
from hal.emulated.pins import Net
from hal.emulated.uart_bytes import FRAME
from hal.emulated.uart_wire import UartWire
from hal.emulated.virtual_time import VirtualTime
from host.attach.receiver_port import ReceiverPort

AHEAD_NS = 20_000_000
"""So much is put on the line ahead of time."""
LONGEST_WAIT_NS = 2_000_000_000
"""Of bytes for their turn on the line."""
MODEL = f"{__name__}:LiveReceiver"


class LiveReceiver:
    """What the board's assembly takes for a chip. Its pins stay as they are: a serial port has none."""

    def __init__(
        self, _time: VirtualTime, _world: GnssWorld, _line: UartWire, *, pin_names: tuple[str, ...]
    ) -> None:
        self.pins: dict[str, Net | None] = dict.fromkeys(pin_names)
        self.is_on = True

    def receive(self, data: bytes, time_ns: int) -> None:
        """What the board sends is taken off the line by `ReceiverLine`, whatever its rate."""

    def power(self, on: bool) -> None:
        """The board switches its supply; the real one goes on, but is not listened to."""
        self.is_on = on


class ReceiverLine:
    """Between port and board, in virtual time."""

    def __init__(self, board: AssembledBoard, refdes: str, port: ReceiverPort) -> None:
        uart = board.description.chips[refdes].uart
        assert uart is not None
        self.bytes_in = 0
        self.bytes_out = 0
        self.bytes_dropped = 0
        """That came faster than the line's rate for too long; only a port without a rate can do that."""
        self.rate_changes = 0
        """Of the board's UART, which the port follows where it can."""
        self.forwarded = 0
        self.forward_ns = 0
        self.longest_forward_ns = 0
        """From the arrival at the port to the board's line."""
        self._waiting: deque[tuple[int, bytes]] = deque()
        self._time = board.time
        self._receiver: LiveReceiver = board.chips[refdes]
        self._port = port
        self._uart = board.ports[uart]
        self._to_board = board.to_board[uart]
        self._ear = board.from_board[uart].connect_late()
        self._followed = port.link.baud
        self._follow()

    def bring_in(self, arrived: list[tuple[int, bytes]]) -> None:
        """Put on the line what has come: (virtual time of its arrival, bytes), none in the future."""
        if not self._receiver.is_on:
            self._waiting.clear()
            return
        now_ns = self._time.now
        self._waiting.extend(arrived)
        self._drop_stale()
        line = self._to_board
        line.set_baud(self._uart.baud)
        while self._waiting and line.idle_from - self._time.now < AHEAD_NS:
            came_ns, data = self._waiting.popleft()
            fits = max(1, AHEAD_NS * self._uart.baud // FRAME)
            if len(data) > fits:
                self._waiting.appendleft((came_ns, data[fits:]))
            line.send(data[:fits])
            self.bytes_in += min(fits, len(data))
            self.forwarded += 1
            late_ns = max(0, now_ns - came_ns)
            self.forward_ns += late_ns
            self.longest_forward_ns = max(self.longest_forward_ns, late_ns)

    def _drop_stale(self) -> None:
        """What came faster than the line's rate and would come too late to mean anything."""
        most = self._uart.baud * LONGEST_WAIT_NS // FRAME
        waiting = sum(len(data) for _, data in self._waiting)
        while waiting > most:
            _, data = self._waiting.popleft()
            waiting -= len(data)
            self.bytes_dropped += len(data)

    def hand_out(self) -> None:
        """Send to the receiver what the board has sent, then take over the board's rate."""
        data, _errors = self._ear.take()
        if data:
            self.bytes_out += self._port.link.write(data)
        self._follow()

    def _follow(self) -> None:
        baud = self._uart.baud
        if baud != self._followed:
            self._followed = baud
            self.rate_changes += 1
            if self._port.baud is not None:
                self._port.link.set_baud(baud)
        self._to_board.set_baud(baud)
