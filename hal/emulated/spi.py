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

import struct
from abc import ABC, abstractmethod
from collections.abc import Callable

from hal.emulated.cpu import EmulatedCpu
from hal.emulated.spi_wire import Bytes, SpiObserver, SpiSlave, SpiTiming

__all__ = ["Bytes", "EmulatedSpiBus", "EmulatedSpiDevice", "SpiObserver", "SpiSlave", "SpiTiming"]


class EmulatedSpiBus:
    """The wires and the controller that several devices share."""

    __slots__ = ("_devices", "at_work", "cpu", "free_at", "name", "timing", "waits")

    def __init__(self, cpu: EmulatedCpu, timing: SpiTiming, name: str = "spi") -> None:
        self.cpu = cpu
        self.timing = timing
        self.name = name
        self.at_work = False
        """Whether a transaction may be under way that something else can come between."""
        self.free_at = 0
        """When that transaction ends (ns)."""
        self.waits = 0
        """Transactions that found the wire busy: an interrupt used the bus that it had interrupted."""
        self._devices: list[EmulatedSpiDevice] = []
        cpu.reset_hooks.append(self._reset)

    @property
    def transactions(self) -> int:
        """How many have begun."""
        return sum(use.count for device in self._devices for use in device.uses())

    @property
    def busy_ns(self) -> int:
        """What they take together."""
        return sum(use.count * use.duration_ns for device in self._devices for use in device.uses())

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
        device = EmulatedSpiDevice(self, slave, name, timing)
        self._devices.append(device)
        return device

    def _reset(self) -> None:
        """The controller drops what it was doing; the chip has seen the transaction all the same."""
        self.at_work = False
        self.free_at = self.cpu.time.now


class SpiChip(ABC):
    """A slave whose model is translated with the engine: it is called without a detour."""

    __slots__ = ()

    @abstractmethod
    def transaction(self, mosi: Bytes, start_ns: int, end_ns: int) -> Bytes:
        """See `SpiSlave`."""


class SpiUse:
    """Transactions of one length: how long one takes, how many there were, and what puts the bytes that came
    into the buffer (which takes a third of the time of an assignment to its slice)."""

    __slots__ = ("count", "duration_ns", "put")

    def __init__(self, length: int, timing: SpiTiming) -> None:
        self.duration_ns = timing.duration_ns(length)
        self.count = 0
        self.put = struct.Struct(f"{length}s").pack_into


class SpiTape:
    """An observer that keeps transactions as records of `pack(n)`: start, duration, n and the bytes of both
    sides. `records` is whoever's it is that takes them; `pairs` holds MOSI of those of two bytes."""

    __slots__ = ("_length", "_pack", "_pack_of", "pairs", "records")

    def __init__(self, pack_of: Callable[[int], Callable[..., bytes]]) -> None:
        self.records: list[bytes] = []
        self.pairs: list[bytes] = []
        self._pack_of = pack_of
        self._length = -1
        self._pack = pack_of(0)

    def __call__(self, start_ns: int, end_ns: int, mosi: Bytes, miso: Bytes) -> None:
        """See `SpiObserver`."""
        self.take(start_ns, end_ns, mosi, miso)

    def take(self, start_ns: int, end_ns: int, mosi: Bytes, miso: Bytes) -> None:
        """The same, called without a detour."""
        length = len(mosi)
        if length != self._length:
            self._pack, self._length = self._pack_of(length), length
        pack = self._pack
        try:
            record = pack(start_ns, end_ns - start_ns, length, mosi, miso)
        except struct.error:  # neither bytes nor bytearray
            record = pack(start_ns, end_ns - start_ns, length, bytes(mosi), bytes(miso))
        self.records.append(record)
        if length == 2:
            self.pairs.append(bytes(mosi))


class EmulatedSpiDevice:
    """One chip select. Implements `hal.spi.SpiDevice`.

    `slave` may be exchanged at any moment (faults do), `observer` sees every transaction as it starts.
    """

    __slots__ = (
        "_chip",
        "_cpu",
        "_high_ns",
        "_observer",
        "_ready_at",
        "_slave",
        "_tape",
        "_time",
        "_uses",
        "bus",
        "name",
        "timing",
    )

    def __init__(self, bus: EmulatedSpiBus, slave: SpiSlave, name: str, timing: SpiTiming) -> None:
        self.bus = bus
        self.timing = timing
        self.name = name
        self._slave: SpiSlave = slave
        self._chip: SpiChip | None = None
        """The slave, if it is one of the engine's."""
        self.slave = slave
        self._observer: SpiObserver | None = None
        self._tape: SpiTape | None = None
        """The observer, if it is one of the engine's."""
        self._cpu = bus.cpu
        self._time = bus.cpu.time
        self._uses: list[SpiUse | None] = []
        """By length in bytes."""
        self._high_ns = timing.high_ns
        self._ready_at = 0

    def transaction(self, buffer: bytearray) -> None:
        """Exchange the whole buffer in place.

        Mostly nothing is due before the wire is free again; then the bus need not be marked as taken.
        """
        time = self._time
        start = time.now
        if self.bus.at_work or start < self._ready_at:
            start = self._wait_for_wire()
        length = len(buffer)
        use = self._uses[length] if length < len(self._uses) else None
        if use is None:
            use = self._first_of(length)
        use.count += 1
        end = start + use.duration_ns
        chip = self._chip
        if chip is not None:
            miso = chip.transaction(buffer, start, end)
        else:
            miso = self._slave.transaction(buffer, start, end)
        if len(miso) != length:
            raise ValueError(f"slave {self.name!r} answered {len(miso)} bytes to a transaction of {length}")
        tape = self._tape
        if tape is not None:
            tape.take(start, end, buffer, miso)
        else:
            observer = self._observer
            if observer is not None:
                observer(start, end, buffer, miso)
        if end < time.limit:
            time.now = end
            if self._high_ns:
                self._ready_at = end + self._high_ns
        else:
            self._hold_wire(end)
        try:
            use.put(buffer, 0, miso)
        except struct.error:  # other bytes than `Bytes`
            buffer[:] = miso

    @property
    def slave(self) -> SpiSlave:
        """The bus face behind this chip select."""
        return self._slave

    @slave.setter
    def slave(self, slave: SpiSlave) -> None:
        self._slave = slave
        self._chip = slave if isinstance(slave, SpiChip) else None

    @property
    def observer(self) -> SpiObserver | None:
        """Told of every transaction as it starts."""
        return self._observer

    @observer.setter
    def observer(self, observer: SpiObserver | None) -> None:
        self._observer = observer
        self._tape = observer if isinstance(observer, SpiTape) else None

    def uses(self) -> list[SpiUse]:
        """Of all lengths that there were."""
        return [use for use in self._uses if use is not None]

    def _first_of(self, length: int) -> SpiUse:
        """The first transaction of a length. Raises ValueError for half words."""
        use = SpiUse(length, self.timing)
        self._uses += [None] * (length + 1 - len(self._uses))
        self._uses[length] = use
        return use

    def _wait_for_wire(self) -> int:
        """Let time pass until the bus is free and chip select was high for long enough; returns now."""
        bus, ready_at = self.bus, self._ready_at
        if not bus.at_work and ready_at < self._time.limit:
            self._time.now = ready_at
            return ready_at
        if self._time.now < bus.free_at:
            bus.waits += 1
        while self._time.now < (free := max(bus.free_at, self._ready_at)):
            self._cpu.wait_until(free)
        bus.at_work = False
        return self._time.now

    def _hold_wire(self, end_ns: int) -> None:
        """Let time pass to the end of a transaction that has begun, whatever comes between."""
        bus = self.bus
        bus.free_at = end_ns
        bus.at_work = True
        self._ready_at = end_ns + self._high_ns
        self._cpu.wait_until(end_ns)
