"""A bench for parts of the program without a board: nothing takes time, nothing interrupts, nothing answers.

What the program says on its host port is kept in `sent`.
"""

from __future__ import annotations

from collections.abc import Callable

from hal.board_io import BoardIo
from hal.interrupts import LineFigures

ROOM = 4096
BAUD = 230_400


class Bench:
    """Everything that a program's parts ask for when they are made."""

    def __init__(self) -> None:
        self.sent = bytearray()

    def io(self) -> BoardIo:
        """The program's view of the bench."""
        core = _Core()
        return BoardIo(
            cpu=core,
            clock=core,
            interrupts=core,
            watchdog=core,
            spi={"imu": _NoChip()},
            uart={"host": _Port(self.sent), "gnss": _Port(bytearray())},
            outputs={"gnss_enable": _Pin()},
        )


class _Core:
    """Processor, clock, interrupt controller and watchdog."""

    def cost(self, _work: str) -> int:
        """Nothing costs."""
        return 0

    def spend(self, cycles: int) -> None:
        """No time passes."""

    def wait_for_interrupt(self) -> None:
        """Nothing ever comes."""

    def delay(self, duration_ns: int) -> None:
        """No time passes."""

    def now_ns(self) -> int:
        """No time has passed."""
        return 0

    def attach(self, _name: str, _handler: Callable[[], None]) -> _Line:
        """A line that is never served."""
        return _Line()

    def figures(self) -> list[LineFigures]:
        """Nothing has run."""
        return []

    def start(self, timeout_ns: int) -> None:
        """The watchdog does not bite."""

    def kick(self) -> None:
        """Nor need it be kicked."""


class _Line:
    def pend(self) -> None:
        """Nobody serves it."""

    def enable(self) -> None:
        """Nobody serves it."""

    def disable(self) -> None:
        """Nobody serves it."""


class _Port:
    """A port that has always room and never receives."""

    def __init__(self, sent: bytearray) -> None:
        self.baud = BAUD
        self._sent = sent

    def set_baud(self, baud: int) -> None:
        """Kept."""
        self.baud = baud

    def write(self, data: bytes) -> int:
        """Kept."""
        self._sent += data
        return len(data)

    def tx_free(self) -> int:
        """Always the same."""
        return ROOM

    def start_receive(self, ring: bytearray, line: object) -> None:
        """Nothing will come."""

    def received(self) -> int:
        """Nothing has come."""
        return 0

    def take_errors(self) -> int:
        """None."""
        return 0


class _Pin:
    def set(self, level: bool) -> None:
        """Drives nothing."""


class _NoChip:
    def transaction(self, buffer: bytearray) -> None:
        """Nobody answers: the bus stays high."""
        buffer[:] = b"\xff" * len(buffer)
