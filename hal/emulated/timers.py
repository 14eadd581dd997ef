"""Hardware timers: both run on the processor's crystal and are off after a reset."""

from __future__ import annotations

from math import gcd
from typing import SupportsIndex

from hal.emulated.cpu import EmulatedCpu
from hal.emulated.interrupt_line import EmulatedLine, emulated_line
from hal.emulated.pins import Net
from hal.emulated.virtual_time import SECOND, Event
from hal.emulated.whole_number import whole_number
from hal.interrupts import InterruptLine
from hal.pins import Edge


class EmulatedPeriodicTimer:
    """Implements `hal.timers.PeriodicTimer`.

    A crystal that is fast by e parts in 10⁹ shows n / rate seconds after n·10¹⁸ / (rate·(10⁹ + e)) ns.
    """

    def __init__(self, cpu: EmulatedCpu) -> None:
        self._cpu = cpu
        self._event: Event | None = None
        cpu.reset_hooks.append(self.stop)

    def start(self, rate_hz: SupportsIndex, line: InterruptLine) -> None:
        """First expiry one period from now, the n-th at n / rate_hz; a running timer starts anew."""
        rate = whole_number(rate_hz, "timer rate in Hz")
        if rate <= 0:
            raise ValueError(f"timer rate of {rate} Hz; it must be positive, e.g. 100")
        self.stop()
        request = emulated_line(line).request
        divisor = rate * (SECOND + self._cpu.crystal_error_ppb)
        common = gcd(SECOND * SECOND, divisor)
        divisor //= common
        whole, part = divmod(SECOND * SECOND // common, divisor)
        due, rest = self._cpu.time.now + whole, part

        def expire() -> int:
            """Goes on by a period of `whole` ns and a fraction `part / divisor`."""
            nonlocal due, rest
            request()
            due += whole
            rest += part
            if rest >= divisor:
                rest -= divisor
                due += 1
            return due

        self._event = self._cpu.time.at(due, expire)

    def stop(self) -> None:
        """No more expiries."""
        if self._event is not None:
            self._event.cancel()
            self._event = None


class EmulatedCaptureTimer:
    """Implements `hal.timers.CaptureTimer` on the rising edges of `net` (or those that `edge` says)."""

    def __init__(self, cpu: EmulatedCpu, net: Net, edge: Edge = Edge.RISING) -> None:
        self._cpu = cpu
        self._net = net
        self._edge = edge
        self._running = False
        self._line: EmulatedLine | None = None
        self._edges = 0
        self._latched_ns = 0
        cpu.reset_hooks.append(self._reset)

    def start(self, line: InterruptLine | None = None) -> None:
        """Capture from now on; pend `line`, when given, at every edge."""
        self._line = None if line is None else emulated_line(line)
        self._edges = self._latched_ns = 0
        if not self._running:
            self._running = True
            for rising in (False, True):
                if self._edge is Edge.BOTH or rising == (self._edge is Edge.RISING):
                    self._net.listen_edge(rising, self._latch)

    def captured(self) -> tuple[int, int]:
        """(edges since `start`, clock in nanoseconds at the last one)."""
        self._cpu.poll()
        return self._edges, self._latched_ns

    def _latch(self) -> None:
        cpu = self._cpu
        self._edges += 1
        self._latched_ns = cpu.clock_at(cpu.time.now)
        if self._line is not None:
            self._line.request()

    def _reset(self) -> None:
        self._edges = self._latched_ns = 0
        if self._running:
            self._running = False
            self._net.ignore_edges(self._latch)
