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
from typing import NamedTuple, Protocol

from hal.emulated.cpu import EmulatedCpu
from hal.emulated.virtual_time import SECOND, VirtualTime
from hal.errors import BusError, ErrorKind

BYTE_CLOCKS = 9
_NOBODY = (None, None, False)


class I2cTransfer(NamedTuple):
    """One transaction, from its start condition to its stop condition."""

    start_ns: int
    end_ns: int
    """When the wire is free again."""
    address: int
    written: bytes
    """What was to be written."""
    acknowledged: int
    """So many of these bytes were."""
    asked: int
    """How many bytes were to be read."""
    read: bytes
    refusal: ErrorKind | None
    """None: nothing was refused. OTHER: broken off by a reset of the processor."""


I2cObserver = Callable[[I2cTransfer], None]
I2cPlayer = Callable[[int, int, bytes, int], I2cTransfer]
"""(start_ns, address, bytes to write, bytes to read) -> what comes of it."""


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

    A slave may have, when it is attached, an attribute `stretch_ns`: how long it holds the clock low after
    its address; a method `listens(time_ns)`: whether it acknowledges its address at all (it may be without
    supply, or busy); and a method `clocked_at(frequency_hz)`, called when it is attached.
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
        """Hears of every transaction as it ends."""
        self.player: I2cPlayer | None = None
        """Takes the place of all slaves: a replay."""
        self.stuck: list[Callable[[], bool]] = []
        """Faults that keep a line of the bus at a level: each hears of a transaction, and tells whether
        nobody can acknowledge; else the bus hangs."""
        self._cpu = cpu
        self._slaves: dict[int, I2cSlave] = {}
        self._manners: dict[int, tuple[I2cSlave, Callable[[int], bool] | None, bool]] = {}
        """For each address the slave, its `listens`, and whether it has a `stretch_ns`."""
        self._steps: dict[tuple[int, int], tuple[int, int, int, int]] = {}
        """By bytes written and read: until they are written, addressed again, over; over when refused."""
        self._address_ns = (1 + BYTE_CLOCKS) * SECOND // frequency_hz
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
        self._put(address, slave)
        clocked_at = getattr(slave, "clocked_at", None)
        if clocked_at is not None:
            clocked_at(self.frequency_hz)

    def detach(self, address: int) -> None:
        """Take a slave off the bus; nobody acknowledges its address any more."""
        del self._slaves[address], self._manners[address]

    @property
    def time(self) -> VirtualTime:
        """The virtual time of its controller."""
        return self._cpu.time

    def slave(self, address: int) -> I2cSlave | None:
        """Who listens at an address."""
        return self._slaves.get(address)

    def exchange(self, address: int, slave: I2cSlave) -> I2cSlave:
        """Put another one in the place of a slave; returns that one."""
        before = self._slaves[address]
        self._put(address, slave)
        return before

    def _put(self, address: int, slave: I2cSlave) -> None:
        self._slaves[address] = slave
        self._manners[address] = (slave, getattr(slave, "listens", None), _may_stretch(slave))

    def transaction(self, address: int, write: bytes = b"", read_length: int = 0) -> bytes:
        """Run one transaction and return the bytes read."""
        if self._owner is not None:
            raise BusError(ErrorKind.OTHER, f"{self.name!r} is busy with a transaction of {self._owner!r}")
        self._owner = self._cpu.running_name
        start = self._cpu.time.now
        if self.player is not None:
            done = self.player(start, address, bytes(write), read_length)
            return self._play(done)
        slave, listens, stretches = self._manners.get(address, _NOBODY)
        usual = bool(write or read_length) and not stretches and self.observer is None and not self.stuck
        if usual and slave is not None and (listens is None or listens(start + self._address_ns)):
            return self._quick(slave, address, bytes(write), read_length)
        wire = _Wire(self._cpu, start, self.frequency_hz)
        try:
            return self._run(wire, address, bytes(write), read_length)
        finally:
            self._owner = None
            end = min(wire.end, self._cpu.time.now)
            self.transactions += 1
            self.busy_ns += end - start
            if self.observer is not None:
                done = I2cTransfer(
                    start, end, address, bytes(write), wire.acknowledged, read_length, wire.read, wire.refusal
                )
                self.observer(done)

    def _quick(self, slave: I2cSlave, address: int, write: bytes, read_length: int) -> bytes:
        """The usual transaction that nobody watches: the same as `_run`, in one piece. An interrupt may
        outlast what is left on the wire: then `now` lies behind its end."""
        cpu, time = self._cpu, self._cpu.time
        start = end = time.now
        lengths = (len(write), read_length)
        steps = self._steps.get(lengths)
        if steps is None:
            self._steps[lengths] = steps = _steps(*lengths, self.frequency_hz)
        written_ns, addressed_ns, over_ns, refused_ns = steps
        try:
            if write:
                end = start + written_ns
                if end < time.limit:
                    time.now = end
                else:
                    cpu.wait_until(end)
                acknowledged = slave.write(write, time.now)
                if acknowledged < len(write):
                    end = start + refused_ns
                    cpu.wait_until(end)
                    raise self._refused(ErrorKind.DATA_NACK, address, acknowledged, len(write))
            read = b""
            if read_length:
                end = start + addressed_ns
                if time.now < end < time.limit:
                    time.now = end
                else:
                    cpu.wait_until(end)
                listens = self._manners.get(address, _NOBODY)[1]
                if listens is not None and not listens(time.now):
                    end = start + addressed_ns + SECOND // self.frequency_hz
                    cpu.wait_until(end)
                    raise self._refused(ErrorKind.ADDRESS_NACK, address)
                read = slave.read(read_length, time.now)
                if len(read) != read_length:
                    raise ValueError(
                        f"slave 0x{address:02X} gave {len(read)} bytes for a read of {read_length}"
                    )
            end = start + over_ns
            if time.now < end < time.limit:
                time.now = end
            else:
                cpu.wait_until(end)
            return read
        finally:
            self._owner = None
            self.transactions += 1
            self.busy_ns += min(end, time.now) - start

    def _play(self, done: I2cTransfer) -> bytes:
        """Let a transaction happen as it is told."""
        broken_off = done.refusal is ErrorKind.OTHER  # the reset that did it will come
        try:
            self._cpu.wait_until(done.end_ns + SECOND * broken_off)
        finally:
            self._owner = None
            self.transactions += 1
            self.busy_ns += done.end_ns - done.start_ns
        if done.refusal is not None:
            raise self._refused(done.refusal, done.address, done.acknowledged, len(done.written))
        return done.read

    def _run(self, wire: _Wire, address: int, write: bytes, read_length: int) -> bytes:
        slave = self._address(wire, address)
        if write:
            wire.clocks(BYTE_CLOCKS * len(write))
            wire.acknowledged = slave.write(write, self._cpu.time.now)
            if wire.acknowledged < len(write):
                wire.clocks(1)
                wire.refusal = ErrorKind.DATA_NACK
                raise self._refused(wire.refusal, address, wire.acknowledged, len(write))
        if read_length:
            if write:
                slave = self._address(wire, address)
            wire.read = slave.read(read_length, self._cpu.time.now)
            if len(wire.read) != read_length:
                raise ValueError(
                    f"slave 0x{address:02X} gave {len(wire.read)} bytes for a read of {read_length}"
                )
        wire.clocks(BYTE_CLOCKS * read_length + 1)
        wire.refusal = None
        return wire.read

    def _address(self, wire: _Wire, address: int) -> I2cSlave:
        """(Repeated) start and address byte."""
        nobody = False
        for strike in self.stuck:
            nobody = strike()
            if not nobody:
                wire.hold(self.stretch_limit_ns)
                wire.refusal = ErrorKind.TIMEOUT
                raise self._refused(wire.refusal, address)
        wire.clocks(1 + BYTE_CLOCKS)
        slave, listens, stretches = self._manners.get(address, _NOBODY)
        if nobody or slave is None or (listens is not None and not listens(self._cpu.time.now)):
            wire.clocks(1)
            wire.refusal = ErrorKind.ADDRESS_NACK
            raise self._refused(wire.refusal, address)
        if not stretches:
            return slave
        stretch_ns: int = slave.stretch_ns  # type: ignore[attr-defined]
        if stretch_ns > self.stretch_limit_ns:
            wire.hold(self.stretch_limit_ns)
            wire.refusal = ErrorKind.TIMEOUT
            raise self._refused(wire.refusal, address)
        if stretch_ns:
            wire.hold(stretch_ns)
        return slave

    def _refused(self, kind: ErrorKind, address: int, acknowledged: int = 0, sent: int = 0) -> BusError:
        told = f"0x{address:02X} on {self.name!r}"
        if kind is ErrorKind.ADDRESS_NACK:
            return BusError(kind, f"nobody at {told}")
        if kind is ErrorKind.DATA_NACK:
            return BusError(kind, f"byte {acknowledged + 1} of {sent} to {told}")
        return BusError(kind, f"{told} holds the clock for more than {self.stretch_limit_ns} ns")

    def _reset(self) -> None:
        self._owner = None


def _may_stretch(slave: I2cSlave) -> bool:
    return hasattr(type(slave), "stretch_ns") or "stretch_ns" in getattr(slave, "__dict__", ())


def _steps(written: int, read: int, frequency_hz: int) -> tuple[int, int, int, int]:
    """Until the bytes are written, the slave is addressed to read, all is over; over when a byte is refused.
    Of a read alone the first address is that of the read."""
    address = 1 + BYTE_CLOCKS
    behind = address + BYTE_CLOCKS * written
    addressed = behind + address if written and read else behind
    over = addressed + BYTE_CLOCKS * read + 1
    first, second, third, fourth = (
        count * SECOND // frequency_hz for count in (behind, addressed, over, behind + 1)
    )
    return first, second, third, fourth


class _Wire:
    """Counts the clocks of one transaction, lets their time pass, and keeps what has come of it by now."""

    __slots__ = ("_clocks", "_cpu", "_frequency_hz", "_start", "acknowledged", "end", "read", "refusal")

    def __init__(self, cpu: EmulatedCpu, start: int, frequency_hz: int) -> None:
        self._cpu = cpu
        self._start = self.end = start
        """`end`: of the clocks so far (ns)."""
        self._frequency_hz = frequency_hz
        self._clocks = 0
        self.acknowledged = 0
        self.read = b""
        self.refusal: ErrorKind | None = ErrorKind.OTHER

    def clocks(self, count: int) -> None:
        self._clocks = clocks = self._clocks + count
        self.end = end = self._start + clocks * SECOND // self._frequency_hz
        time = self._cpu.time
        if time.now < end < time.limit:
            time.now = end
        else:
            self._cpu.wait_until(end)

    def hold(self, duration_ns: int) -> None:
        self._start += duration_ns
        self.clocks(0)
