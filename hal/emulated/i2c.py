"""I²C master on virtual time.

A start, a repeated start and a stop take one clock each, every byte 9 (8 bits and the acknowledge); the
address counts as a byte (fact sheet, section 2). Reading n bytes of a register takes 1 + 18 + 1 + 9 + 9·n + 1
clocks. All clocks of a transaction are counted from its start, so that nothing is rounded twice:

    S addr+W ack  byte ack … | Sr addr+R ack | byte ack … byte nack  P
                             ^ write()       ^ read()

The slave hears of a write when its last byte is on the wire, and gives the bytes of a read when its address
is. A refused byte is noticed there too: the bytes behind it have still been clocked.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from hal.emulated.cpu import EmulatedCpu
from hal.emulated.virtual_time import SECOND
from hal.errors import BusError, ErrorKind

BYTE_CLOCKS = 9

I2cObserver = Callable[[int, int, int, bytes, bytes], None]
"""(start_ns, end_ns, address, bytes written, bytes read)."""


class I2cSlave(Protocol):
    """The bus face of a chip at one 7-bit address."""

    def write(self, data: bytes, time_ns: int) -> int:
        """`data` has been written by now; returns how many of the bytes are acknowledged."""
        ...

    def read(self, length: int, time_ns: int) -> bytes:
        """The master starts to read `length` bytes now; returns exactly so many."""
        ...


class EmulatedI2cBus:
    """One bus with its controller. Implements `hal.i2c.I2cBus`.

    A slave may have an attribute `stretch_ns`: how long it holds the clock low after its address.
    """

    def __init__(
        self, cpu: EmulatedCpu, frequency_hz: int, name: str = "i2c", stretch_limit_ns: int = 25_000_000
    ) -> None:
        if not 0 < frequency_hz <= 1_000_000:
            raise ValueError(
                f"I2C clock of {frequency_hz} Hz on {name!r}; use 100_000, 400_000 or 1_000_000 (at most)"
            )
        self.name = name
        self.frequency_hz = frequency_hz
        self.stretch_limit_ns = stretch_limit_ns
        """Longest stretch that the controller bears before it gives up (SMBus: 25 ms)."""
        self.transactions = 0
        self.busy_ns = 0
        self.observer: I2cObserver | None = None
        self._cpu = cpu
        self._slaves: dict[int, I2cSlave] = {}
        self._owner: str | None = None
        cpu.reset_hooks.append(self._reset)

    def attach(self, address: int, slave: I2cSlave) -> None:
        """Connect a slave. Raises ValueError when the address is reserved or taken."""
        if not 0x08 <= address <= 0x77:
            raise ValueError(
                f"I2C address 0x{address:02X} on {self.name!r}; 7-bit addresses are 0x08 to 0x77"
            )
        if address in self._slaves:
            raise ValueError(
                f"I2C address 0x{address:02X} on {self.name!r} is taken; two chips cannot share it"
            )
        self._slaves[address] = slave

    def detach(self, address: int) -> None:
        """Take a slave off the bus; nobody acknowledges its address any more."""
        del self._slaves[address]

    def transaction(self, address: int, write: bytes = b"", read_length: int = 0) -> bytes:
        """Run one transaction and return the bytes read."""
        if self._owner is not None:
            raise BusError(ErrorKind.OTHER, f"{self.name!r} is busy with a transaction of {self._owner!r}")
        self._owner = self._cpu.running_name
        start = self._cpu.time.now
        wire = _Wire(self._cpu, start, self.frequency_hz)
        read = b""
        try:
            read = self._run(wire, address, write, read_length)
        finally:
            self._owner = None
            end = self._cpu.time.now
            self.transactions += 1
            self.busy_ns += end - start
            if self.observer is not None:
                self.observer(start, end, address, write, read)
        return read

    def _run(self, wire: _Wire, address: int, write: bytes, read_length: int) -> bytes:
        slave = self._address(wire, address)
        if write:
            wire.clocks(BYTE_CLOCKS * len(write))
            acknowledged = slave.write(bytes(write), self._cpu.time.now)
            if acknowledged < len(write):
                wire.clocks(1)
                raise BusError(
                    ErrorKind.DATA_NACK,
                    f"byte {acknowledged + 1} of {len(write)} to 0x{address:02X} on {self.name!r}",
                )
        data = b""
        if read_length:
            if write:
                slave = self._address(wire, address)
            data = slave.read(read_length, self._cpu.time.now)
            if len(data) != read_length:
                raise ValueError(f"slave 0x{address:02X} gave {len(data)} bytes for a read of {read_length}")
            wire.clocks(BYTE_CLOCKS * read_length)
        wire.clocks(1)
        return data

    def _address(self, wire: _Wire, address: int) -> I2cSlave:
        """(Repeated) start and address byte."""
        wire.clocks(1 + BYTE_CLOCKS)
        slave = self._slaves.get(address)
        if slave is None:
            wire.clocks(1)
            raise BusError(ErrorKind.ADDRESS_NACK, f"nobody at 0x{address:02X} on {self.name!r}")
        stretch_ns = getattr(slave, "stretch_ns", 0)
        if stretch_ns > self.stretch_limit_ns:
            wire.hold(self.stretch_limit_ns)
            raise BusError(
                ErrorKind.TIMEOUT,
                f"0x{address:02X} on {self.name!r} holds the clock for more than {self.stretch_limit_ns} ns",
            )
        if stretch_ns:
            wire.hold(stretch_ns)
        return slave

    def _reset(self) -> None:
        self._owner = None


class _Wire:
    """Counts the clocks of one transaction and lets their time pass."""

    def __init__(self, cpu: EmulatedCpu, start: int, frequency_hz: int) -> None:
        self._cpu = cpu
        self._start = start
        self._frequency_hz = frequency_hz
        self._clocks = 0

    def clocks(self, count: int) -> None:
        self._clocks += count
        self._cpu.wait_until(self._start + self._clocks * SECOND // self._frequency_hz)

    def hold(self, duration_ns: int) -> None:
        self._start += duration_ns
        self._cpu.wait_until(self._start + self._clocks * SECOND // self._frequency_hz)
