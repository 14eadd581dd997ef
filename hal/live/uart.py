"""UART in real time, on any port that pyserial opens.

The link's reading thread plays the DMA: it fills the firmware's ring and makes the line pending whenever
bytes have come, so also when the line falls idle behind them. While the port is away nothing comes, and
what is written is lost; `link.counters` tells.
"""

from __future__ import annotations

from threading import Lock

from hal.interrupts import InterruptLine
from hal.live.cpu import LiveCpu
from hal.live.serial_link import SerialLink


class LiveUart:
    """Implements `hal.uart.Uart` on a link, whose bytes go to nobody else."""

    def __init__(self, cpu: LiveCpu, link: SerialLink) -> None:
        self.link = link
        self._cpu = cpu
        self._lock = Lock()
        self._ring: bytearray | None = None
        self._line: InterruptLine | None = None
        self._received = 0
        link.receiver = self._arrive
        cpu.reset_hooks.append(self._reset)

    @property
    def baud(self) -> int:
        """The bit rate of both directions now."""
        return self.link.baud

    def set_baud(self, baud: int) -> None:
        """Change the bit rate once what was written has gone out."""
        self._cpu.safe_point()
        self.link.set_baud(baud)

    def write(self, data: bytes) -> int:
        """Queue bytes for transmission and return how many were taken."""
        self._cpu.safe_point()
        return self.link.write(data) if data else 0

    def tx_free(self) -> int:
        """Room left in the transmit queue, in bytes."""
        self._cpu.safe_point()
        return self.link.free()

    def start_receive(self, ring: bytearray, line: InterruptLine) -> None:
        """Receive into `ring` from its first byte on; what came before is forgotten."""
        if not ring:
            raise ValueError("the receive ring is empty; give a bytearray with room, e.g. bytearray(512)")
        with self._lock:
            self._ring = ring
            self._line = line
            self._received = 0

    def received(self) -> int:
        """Bytes put into the ring since `start_receive`."""
        self._cpu.safe_point()
        return self._received

    def take_errors(self) -> int:
        """Framing errors and overruns since the last call, as far as the port's driver counts them."""
        self._cpu.safe_point()
        return self.link.take_errors()

    def _arrive(self, data: bytes) -> None:
        """In the link's thread."""
        with self._lock:
            ring, line = self._ring, self._line
            if ring is None or line is None:
                return
            size = len(ring)
            at = self._received % size
            kept = data[-size:]
            at = (at + len(data) - len(kept)) % size
            first = kept[: size - at]
            ring[at : at + len(first)] = first
            rest = kept[len(first) :]
            ring[: len(rest)] = rest
            self._received += len(data)
        line.pend()

    def _reset(self) -> None:
        with self._lock:
            self._ring = self._line = None
            self._received = 0
