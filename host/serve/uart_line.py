"""One of the board's UARTs and the endpoint at which it is served.

A UART with a chip at its other end: clients hear what the chip sends, as it arrives at the board, and what
they write reaches the chip by a wire of its own, at the chip's rate; what the board itself sends is not
touched. A UART that leads outside: clients hear what the board sends, and what they write goes into the
board, byte after byte at the line's rate, as traffic that a capture holds.
"""

from __future__ import annotations

import hashlib

from boards.assembly import AssembledBoard
from hal.emulated.uart_bytes import FRAME
from hal.emulated.uart_wire import UartWire
from host.serve.endpoint import Endpoint

AHEAD_NS = 20_000_000
"""So much of what clients write is put on the line ahead of time."""


class UartLine:
    """A served UART. `sent` bytes, with `digest`, are what was offered to clients since the beginning."""

    def __init__(self, board: AssembledBoard, name: str, endpoint: Endpoint) -> None:
        self.name = name
        self.endpoint = endpoint
        self.sent = 0
        self.written = 0
        """Bytes of clients that were put on the line."""
        self._time = board.time
        self._digest = hashlib.sha256()
        to_board, from_board = board.to_board[name], board.from_board[name]
        self.chip = next((r for r, chip in board.description.chips.items() if chip.uart == name), None)
        if self.chip is None:
            self._heard, self._way_in = from_board, to_board
        else:
            self._heard = to_board
            self._way_in = UartWire(board.time, to_board.baud, f"{name}.outside")
            self._way_in.connect(board.chips[self.chip], rate_of=to_board)
        self._ear = self._heard.connect_late()

    @property
    def leads_to(self) -> str:
        """What is at its other end."""
        return "to the board" if self.chip is None else f"with the chip {self.chip}"

    @property
    def baud(self) -> int:
        """The line's rate now: that of what clients hear, and of what they write."""
        return self._heard.baud

    @property
    def digest(self) -> str:
        """SHA-256 of all bytes that were offered to clients."""
        return self._digest.hexdigest()

    def bring_in(self, slice_ns: int) -> None:
        """Put on the line what clients wrote, no more than goes over it in this slice and a little more."""
        wire = self._way_in
        ahead_ns = max(0, wire.idle_from - self._time.now)
        room = (max(AHEAD_NS, slice_ns) - ahead_ns) * self.baud // FRAME
        if room > 0:
            data = self.endpoint.take(room)
            if data:
                wire.set_baud(self.baud)
                self.written += len(data)
                wire.send(data)

    def hand_out(self) -> None:
        """Give clients what came over the line."""
        data, _errors = self._ear.take()
        if data:
            self.sent += len(data)
            self._digest.update(data)
            self.endpoint.send(data)
