"""What a serial line expects of those who listen to it and of what disturbs it.

Not part of the engine (`hal.engine`): a chip may name these as its base classes.
"""

from __future__ import annotations

from typing import Protocol

from hal.emulated.uart_bytes import SentBytes


class UartPeer(Protocol):
    """Whoever listens to a line: a chip, a capture, the host."""

    def receive(self, data: bytes, time_ns: int) -> None:
        """A chunk of bytes, the last of which ended at `time_ns` (now). Must not let time pass."""
        ...


class LineListener(Protocol):
    """Whoever hears of what is put on a line: receivers and tapes."""

    def announce(self, sent: SentBytes) -> None:
        """These bytes will be on the line, behind all that were announced before."""
        ...

    def forget(self, begin_from: int) -> None:
        """Bytes whose start bit lies at `begin_from` or later will not come after all."""
        ...


class LineFault(Protocol):
    """What disturbs a line (`hal.emulated.faults` has them)."""

    frame_by_frame: bool
    """Whether `frame` has to see every byte."""
    breaks_frame: bool
    """Whether the byte under way when the fault begins is lost."""

    def sent(self, data: bytes) -> bytes:
        """What the transmitter really queues of `data`."""
        ...

    def frame(self, value: int) -> int | None:
        """What becomes of one byte that begins now; None when it is lost, with NO_STOP_BIT when its stop bit
        is low, with NOT_TAKEN when the port misses it."""
        ...
