"""SPI master on virtual time.

    CS   ‾‾\\__________________________________________________/‾‾‾‾‾‾‾‾‾‾‾
           |set-up|word|stall|word|stall| … |word|hold|  high before the next

A transaction of w words of b bits takes

    set-up + ⌊(w·b + (w−1)·stall clocks)·10⁹ / f⌋ + (w−1)·stall + hold            (fact sheet, section 1)

The slave is called once, at the falling edge of chip select; then the wire is busy for that long. The
controller works a transfer off on its own: interrupts that run meanwhile do not make it longer, and one
of them that starts a transfer on the same bus waits until the wire is free.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from hal.emulated.cpu import EmulatedCpu
from hal.emulated.virtual_time import SECOND

Bytes = bytes | bytearray

SpiObserver = Callable[[int, int, Bytes, Bytes], None]
"""(start_ns, end_ns, mosi, miso); the byte strings are valid during the call only."""


class SpiSlave(Protocol):
    """The bus face of a chip."""

    def transaction(self, mosi: Bytes, start_ns: int, end_ns: int) -> bytes:
        """One chip-select low period from `start_ns` to `end_ns` with everything clocked out in it.

        Returns exactly len(mosi) bytes. Reads see the registers as of `start_ns`; writes take effect.
        Must not change or keep `mosi`.
        """
        ...


@dataclass(frozen=True)
class SpiTiming:
    """How a device is clocked. `stall_*`: pause between words inside a transaction; `high_ns`: shortest
    time that chip select stays high between two transactions."""

    frequency_hz: int
    bits_per_word: int = 8
    stall_ns: int = 0
    stall_clocks: int = 0
    setup_ns: int = 0
    hold_ns: int = 0
    high_ns: int = 0

    def __post_init__(self) -> None:
        if self.frequency_hz <= 0:
            raise ValueError(f"SPI clock of {self.frequency_hz} Hz; it must be positive, e.g. 5_250_000")
        if self.bits_per_word not in (8, 16, 32):
            raise ValueError(f"SPI words of {self.bits_per_word} bits; 8, 16 and 32 are possible")
        for name in ("stall_ns", "stall_clocks", "setup_ns", "hold_ns", "high_ns"):
            if getattr(self, name) < 0:
                raise ValueError(f"SPI timing {name} = {getattr(self, name)}; it must not be negative")

    def duration_ns(self, length: int) -> int:
        """Chip-select low time of a transaction of `length` bytes. Raises ValueError for half words."""
        bits = 8 * length
        words, rest = divmod(bits, self.bits_per_word)
        if rest or not words:
            raise ValueError(
                f"SPI transaction of {length} bytes; with words of {self.bits_per_word} bits it must be a "
                f"positive multiple of {self.bits_per_word // 8} bytes"
            )
        clocks = bits + (words - 1) * self.stall_clocks
        pauses = self.setup_ns + (words - 1) * self.stall_ns + self.hold_ns
        return clocks * SECOND // self.frequency_hz + pauses


class EmulatedSpiBus:
    """The wires and the controller that several devices share."""

    __slots__ = ("busy_ns", "cpu", "free_at", "name", "timing", "transactions", "waits")

    def __init__(self, cpu: EmulatedCpu, timing: SpiTiming, name: str = "spi") -> None:
        self.cpu = cpu
        self.timing = timing
        self.name = name
        self.free_at = 0
        """When the transaction at work ends (ns)."""
        self.transactions = 0
        self.busy_ns = 0
        self.waits = 0
        """Transactions that found the wire busy: an interrupt used the bus that it had interrupted."""
        cpu.reset_hooks.append(self._reset)

    def device(
        self, slave: SpiSlave, name: str = "device", timing: SpiTiming | None = None
    ) -> EmulatedSpiDevice:
        """A further chip select with `slave` behind it, clocked as the bus unless `timing` says otherwise.

        A slave that has `clocked_at(frequency_hz)` is told its clock.
        """
        timing = timing or self.timing
        told = getattr(slave, "clocked_at", None)
        if told is not None:
            told(timing.frequency_hz)
        return EmulatedSpiDevice(self, slave, name, timing)

    def _reset(self) -> None:
        """The controller drops what it was doing; the chip has seen the transaction all the same."""
        self.free_at = self.cpu.time.now


class EmulatedSpiDevice:
    """One chip select. Implements `hal.spi.SpiDevice`.

    `slave` may be exchanged at any moment (faults do), `observer` sees every transaction as it starts.
    """

    __slots__ = (
        "_cpu",
        "_durations",
        "_high_ns",
        "_ready_at",
        "_time",
        "bus",
        "name",
        "observer",
        "slave",
        "timing",
    )

    def __init__(self, bus: EmulatedSpiBus, slave: SpiSlave, name: str, timing: SpiTiming) -> None:
        self.bus = bus
        self.timing = timing
        self.name = name
        self.slave = slave
        self.observer: SpiObserver | None = None
        self._cpu = bus.cpu
        self._time = bus.cpu.time
        self._durations: dict[int, int] = {}
        self._high_ns = timing.high_ns
        self._ready_at = 0

    def transaction(self, buffer: bytearray) -> None:
        """Exchange the whole buffer in place."""
        bus = self.bus
        time = self._time
        start = time.now
        if start < bus.free_at or start < self._ready_at:
            start = self._wait_for_wire()
        length = len(buffer)
        try:
            duration = self._durations[length]
        except KeyError:
            duration = self._duration(length)
        bus.free_at = end = start + duration
        bus.transactions += 1
        bus.busy_ns += duration
        if self._high_ns:
            self._ready_at = end + self._high_ns
        miso = self.slave.transaction(buffer, start, end)
        if len(miso) != length:
            raise ValueError(f"slave {self.name!r} answered {len(miso)} bytes to a transaction of {length}")
        if self.observer is not None:
            self.observer(start, end, buffer, miso)
        if end < time.limit:
            time.now = end
        else:
            self._cpu.wait_until(end)
        buffer[:] = miso

    def _wait_for_wire(self) -> int:
        """Let time pass until the bus is free and chip select was high for long enough; returns now."""
        bus = self.bus
        if self._time.now < bus.free_at:
            bus.waits += 1
        while self._time.now < (free := max(bus.free_at, self._ready_at)):
            self._cpu.wait_until(free)
        return self._time.now

    def _duration(self, length: int) -> int:
        duration = self.timing.duration_ns(length)
        self._durations[length] = duration
        return duration
