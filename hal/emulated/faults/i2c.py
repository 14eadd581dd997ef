"""Faults on an I²C bus: at one address, or on a line that all share."""

from __future__ import annotations

from hal.emulated.faults.chance import BitErrors
from hal.emulated.faults.fault import Fault
from hal.emulated.i2c import EmulatedI2cBus, I2cSlave
from hal.emulated.virtual_time import FAR


class I2cFault(Fault):
    """Stands between the bus and one of its slaves while it is at work; passes everything on."""

    inner: I2cSlave
    _bus: EmulatedI2cBus

    def install(self, bus: EmulatedI2cBus, address: int) -> None:
        """Put the fault at `address` for its time. Raises ValueError when nobody is there."""
        if bus.slave(address) is None:
            raise ValueError(f"nobody at 0x{address:02X} on {bus.name!r}")
        self._bus = bus

        def begin() -> None:
            self.inner = bus.exchange(address, self)

        def end() -> None:
            outer = bus.slave(address)
            if outer is self:
                bus.exchange(address, self.inner)
                return
            while isinstance(outer, I2cFault) and outer.inner is not self:
                outer = outer.inner
            assert isinstance(outer, I2cFault)
            outer.inner = self.inner

        self._schedule(bus.time, begin, end)

    @property
    def stretch_ns(self) -> int:
        """How long the clock is held low behind the address."""
        held_ns: int = getattr(self.inner, "stretch_ns", 0)
        return held_ns

    def listens(self, time_ns: int) -> bool:
        """Whether the address is acknowledged."""
        listens = getattr(self.inner, "listens", None)
        return listens is None or bool(listens(time_ns))

    def write(self, data: bytes, time_ns: int) -> int:
        """Bytes from the master; how many of them are acknowledged."""
        return self.inner.write(data, time_ns)

    def read(self, length: int, time_ns: int) -> bytes:
        """Bytes for the master."""
        return self.inner.read(length, time_ns)


class I2cNack(I2cFault):
    """The address is not acknowledged (the chip is not there), or no byte from `byte` on (0: the first one
    behind the address). `fired`: refusals."""

    def __init__(self, start_ns: int, end_ns: int = FAR, byte: int = -1) -> None:
        super().__init__(start_ns, end_ns)
        if byte < -1:
            raise ValueError(f"refusal from byte {byte} on; it is −1 for the address, or 0, 1, …")
        self._byte = byte

    def listens(self, time_ns: int) -> bool:
        """Not when it is the address that is refused."""
        if self._byte < 0:
            self.fired += 1
            return False
        return super().listens(time_ns)

    def write(self, data: bytes, time_ns: int) -> int:
        """The chip hears what was acknowledged."""
        if len(data) <= self._byte:
            return super().write(data, time_ns)
        self.fired += 1
        return super().write(data[: self._byte], time_ns) if self._byte else 0


class I2cBitErrors(I2cFault):
    """Every data bit of one direction ("read" or "write") is flipped with a probability. `fired`: bits."""

    def __init__(
        self,
        start_ns: int,
        end_ns: int,
        probability: float,
        seed: int,
        name: str,
        line: str = "read",
    ) -> None:
        super().__init__(start_ns, end_ns)
        if line not in ("read", "write"):
            raise ValueError(f"I2C bit errors on line {line!r}; it is 'read' or 'write'")
        self._on_write = line == "write"
        self._errors = BitErrors(probability, seed, f"{name}.{line}")

    def write(self, data: bytes, time_ns: int) -> int:
        """To the chip."""
        return super().write(self._disturbed(data) if self._on_write else data, time_ns)

    def read(self, length: int, time_ns: int) -> bytes:
        """From the chip."""
        data = super().read(length, time_ns)
        return data if self._on_write else self._disturbed(data)

    def _disturbed(self, data: bytes) -> bytes:
        disturbed, flipped = self._errors.disturb(data)
        self.fired += flipped
        return disturbed


class I2cClockStretch(I2cFault):
    """The chip answers late: it holds the clock for `hold_ms` behind its address. Beyond what the controller
    bears (25 ms) that is a timeout. `fired`: times."""

    def __init__(self, start_ns: int, end_ns: int, hold_ms: float) -> None:
        super().__init__(start_ns, end_ns)
        if not 0.0 < hold_ms <= 1000.0:
            raise ValueError(f"clock held for {hold_ms} ms; it must lie above 0 and not above 1000, e.g. 2.0")
        self._hold_ns = round(hold_ms * 1e6)

    @property
    def stretch_ns(self) -> int:
        """The chip's own, and the fault's."""
        self.fired += 1
        return super().stretch_ns + self._hold_ns


class I2cStuckLine(Fault):
    """SDA or SCL of the whole bus stays at a level. `fired`: transactions that came to nothing.

    Low, no start condition can be made, and high, no clock: the controller gives up after the time that it
    bears (25 ms). With SDA high nobody can acknowledge.
    """

    def __init__(self, start_ns: int, end_ns: int = FAR, line: str = "sda", level: bool = False) -> None:
        super().__init__(start_ns, end_ns)
        if line not in ("sda", "scl"):
            raise ValueError(f"stuck I2C line {line!r}; it is 'sda' or 'scl'")
        self._nobody_answers = line == "sda" and level

    def install(self, bus: EmulatedI2cBus) -> None:
        """Put the fault on `bus` for its time."""

        def begin() -> None:
            bus.stuck.append(self.strike)

        def end() -> None:
            bus.stuck.remove(self.strike)

        self._schedule(bus.time, begin, end)

    def strike(self) -> bool:
        """A transaction begins; returns whether the bus is quiet but works (else it hangs)."""
        self.fired += 1
        return self._nobody_answers
