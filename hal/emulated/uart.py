"""UART of a processor, on virtual time: transmission and reception by DMA.

The receive ring is filled when somebody could look: at an interrupt or at a read of the counter, exactly
as far as bytes have ended by then. The line is pended when the count of bytes reaches half the ring and
its end, and when the line has been high for one frame (10 bits of the receiver) after the last byte.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import SupportsIndex

from hal.emulated.cpu import EmulatedCpu
from hal.emulated.interrupt_line import EmulatedLine, emulated_line
from hal.emulated.uart_bytes import FRAME
from hal.emulated.uart_faces import UartPeer
from hal.emulated.uart_receiver import LineReceiver
from hal.emulated.uart_wire import UartWire
from hal.emulated.virtual_time import FAR
from hal.emulated.whole_number import whole_number
from hal.interrupts import InterruptLine

__all__ = ["EmulatedUart", "UartPeer", "UartWire"]


class EmulatedUart:
    """One port between two wires. Implements `hal.uart.Uart`.

    The transmit queue is as deep as the capacity of the wire `tx`.
    """

    def __init__(self, cpu: EmulatedCpu, tx: UartWire, rx: UartWire, name: str = "uart") -> None:
        if tx.capacity is None:
            raise ValueError(
                f"the wire {tx.name!r} that a processor drives needs a capacity, e.g. 1024 bytes"
            )
        self.name = name
        self.tx = tx
        self.rx = rx
        self._cpu = cpu
        self._power_on_baud = tx.baud
        self._receiver = _RingReceiver(cpu, tx)
        rx.attach(self._receiver)
        cpu.reset_hooks.append(self._reset)

    @property
    def baud(self) -> int:
        """The bit rate of both directions now."""
        return self.tx.baud

    def set_baud(self, baud: SupportsIndex) -> None:
        """Change the bit rate of both directions for the bytes that follow."""
        rate = whole_number(baud, "baud rate")
        if rate != self.tx.baud:
            self.tx.set_baud(rate)
            self._receiver.rate_changed()

    def write(self, data: Iterable[int]) -> int:
        """Queue bytes for transmission and return how many were taken."""
        return self.tx.send(data)

    def tx_free(self) -> int:
        """Room left in the transmit queue."""
        self._cpu.poll()
        free = self.tx.free
        assert free is not None
        return free

    def start_receive(self, ring: bytearray, line: InterruptLine) -> None:
        """Receive into `ring` by circular DMA from its first byte on."""
        if not ring:
            raise ValueError("the receive ring is empty; give a bytearray with room, e.g. bytearray(512)")
        self._receiver.start(ring, emulated_line(line))

    def received(self) -> int:
        """Bytes put into the ring since `start_receive`."""
        self._cpu.poll()
        self._receiver.fill()
        return self._receiver.count

    def take_errors(self) -> int:
        """Framing errors and overruns since the last call."""
        self._cpu.poll()
        self._receiver.fill()
        errors, self._receiver.errors = self._receiver.errors, 0
        return errors

    @property
    def errors(self) -> int:
        """Framing errors and overruns since power-on, whatever the firmware has taken."""
        self._receiver.fill()
        return self._receiver.total_errors

    def _reset(self) -> None:
        self.tx.abort()
        self.tx.set_baud(self._power_on_baud)
        self._receiver.stop()


class _RingReceiver(LineReceiver):
    """The receive half: circular DMA with half, full and idle interrupts."""

    def __init__(self, cpu: EmulatedCpu, tx: UartWire) -> None:
        super().__init__(cpu.time, lambda: tx.baud)
        self._tx = tx
        self.count = 0
        self.errors = 0
        self.total_errors = 0
        self._ring: bytearray | None = None
        self._interrupt: EmulatedLine | None = None
        self._overrun = False
        self._boundary = 0
        self._idle_count = 0

    def start(self, ring: bytearray, line: EmulatedLine) -> None:
        """Fill `ring` from its first byte on with what ends from now on."""
        self.fill()
        self._ring = ring
        self._interrupt = line
        self.count = self._idle_count = 0
        self._boundary = self._next_boundary()
        self._alarm.by(self._next_instant())

    def stop(self) -> None:
        """As after power-on."""
        self.fill()
        self._ring = self._interrupt = None
        self.errors = 0
        self._overrun = False

    def fill(self) -> None:
        """Put what has arrived into the ring. What comes before there is one is lost: one overrun."""
        data, errors = self.take()
        self.errors += errors
        self.total_errors += errors
        if not data:
            return
        ring = self._ring
        if ring is None:
            self.errors += not self._overrun
            self.total_errors += not self._overrun
            self._overrun = True
            return
        size = len(ring)
        if len(data) > size:
            self.count += len(data) - size
            data = data[-size:]
        at = self.count % size
        first = min(len(data), size - at)
        ring[at : at + first] = data[:first]
        ring[: len(data) - first] = data[first:]
        self.count += len(data)

    def _next_boundary(self) -> int:
        assert self._ring is not None
        size = len(self._ring)
        rounds, position = divmod(self.count, size)
        half = size // 2
        return rounds * size + (half if position < half else size)

    def _next_instant(self) -> int:
        if self._ring is None:
            return self.arrivals[-1].end if self.arrivals else FAR
        idle = FRAME // self._tx.baud
        quiet_from = self.last_end if self.count != self._idle_count else None
        to_go = self._boundary - self.count
        for batch in self.arrivals:
            if quiet_from is not None and batch.begin - quiet_from >= idle:
                break
            if to_go <= len(batch.data):
                return batch.end_of(to_go - 1)
            to_go -= len(batch.data)
            quiet_from = batch.end
        return FAR if quiet_from is None else quiet_from + idle

    def _due(self) -> int:
        self.fill()
        if self._ring is None or self._interrupt is None:
            return self._next_instant()
        notable = self.count >= self._boundary
        if notable:
            self._boundary = self._next_boundary()
        if self.count != self._idle_count and self._quiet_until() - self.last_end >= FRAME // self._tx.baud:
            self._idle_count = self.count
            notable = True
        if notable:
            self._interrupt.request()
        return self._next_instant()

    def _quiet_until(self) -> int:
        """How long the line has been high by now, or was until a byte that is under way."""
        now = self._time.now
        return min(now, self.arrivals[0].begin) if self.arrivals else now
