"""Faults on wires: each is at work from `start_ns` to `end_ns` and counts in `fired` how often it struck.

    fault = SpiBitErrors(start_ns=10 * SECOND, end_ns=11 * SECOND, probability=1e-4, seed=1, name="imu")
    fault.install(device)

A fault may be installed at any moment before its end, several at once; outside its time it costs nothing.
Random ones draw from a PCG64 generator seeded by (seed, name), so that no other draw changes theirs.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hal.emulated.can import EmulatedCanBus
from hal.emulated.spi import Bytes, EmulatedSpiDevice, SpiSlave
from hal.emulated.uart_wire import UartWire
from hal.emulated.virtual_time import FAR, VirtualTime

FASTEST_BAUD = 100_000_000
LONGEST_GARBAGE = 10_000_000
"""Bytes; a quarter of an hour at 115,200 baud."""


class Fault:
    """Base of all faults."""

    def __init__(self, start_ns: int, end_ns: int = FAR) -> None:
        if not 0 <= start_ns < end_ns:
            raise ValueError(
                f"fault from {start_ns} ns to {end_ns} ns; it must start at 0 or later and then end"
            )
        self.start_ns = start_ns
        self.end_ns = end_ns
        self.fired = 0
        self._at_work: bool | None = None
        """None: not yet; False: it has passed."""
        self._end: Callable[[], None] = _nothing

    def lift(self) -> None:
        """End it now, or see to it that it does not begin. Harmless when it has passed."""
        end = self._end if self._at_work else _nothing
        self._at_work = False
        end()

    def _schedule(self, time: VirtualTime, begin: Callable[[], None], end: Callable[[], None]) -> None:
        if self.end_ns <= time.now:
            raise ValueError(f"fault ends at {self.end_ns} ns, which has passed (now {time.now} ns)")
        self._end = end
        if self.start_ns <= time.now:
            self._begin(begin)
        else:
            time.at(self.start_ns, lambda: self._begin(begin))
        if self.end_ns < FAR:
            time.at(self.end_ns, self.lift)

    def _begin(self, begin: Callable[[], None]) -> None:
        if self._at_work is None:
            self._at_work = True
            begin()


def _nothing() -> None:
    pass


class BitErrors:
    """Flips single bits with a probability each, by drawing the distance to the next error."""

    def __init__(self, probability: float, seed: int, name: str) -> None:
        if not 0.0 <= probability <= 1.0:
            raise ValueError(f"bit error probability {probability!r}; it must lie in 0 … 1, e.g. 1e-4")
        sequence = np.random.SeedSequence([seed, *name.encode()])
        self._random = np.random.Generator(np.random.PCG64(sequence))
        self._probability = probability
        self._good_bits = self._distance()

    def disturb(self, data: bytes) -> tuple[bytes, int]:
        """`data` with errors, and how many bits were flipped."""
        bits = 8 * len(data)
        if self._good_bits >= bits:
            self._good_bits -= bits
            return data, 0
        disturbed = bytearray(data)
        flipped = 0
        position = self._good_bits
        while position < bits:
            disturbed[position >> 3] ^= 0x80 >> (position & 7)
            flipped += 1
            position += 1 + self._distance()
        self._good_bits = position - bits
        return bytes(disturbed), flipped

    def _distance(self) -> int:
        return int(self._random.geometric(self._probability)) - 1 if self._probability else FAR


# -- SPI -------------------------------------------------------------------------------------------


class SpiFault(Fault):
    """Stands between a chip select and the chip while it is at work."""

    inner: SpiSlave

    def install(self, device: EmulatedSpiDevice) -> None:
        """Put the fault on the wires of `device` for its time."""

        def begin() -> None:
            self.inner = device.slave
            device.slave = self

        def end() -> None:
            if device.slave is self:
                device.slave = self.inner
                return
            outer = device.slave
            while isinstance(outer, SpiFault) and outer.inner is not self:
                outer = outer.inner
            assert isinstance(outer, SpiFault)
            outer.inner = self.inner

        self._schedule(device.bus.cpu.time, begin, end)

    def transaction(self, mosi: Bytes, start_ns: int, end_ns: int) -> bytes:
        """What the bus sees instead of the chip."""
        raise NotImplementedError


class SpiBitErrors(SpiFault):
    """Every bit on one line is flipped with a probability. `fired`: bits flipped."""

    def __init__(
        self,
        start_ns: int,
        end_ns: int,
        probability: float,
        seed: int,
        name: str,
        line: str = "miso",
    ) -> None:
        super().__init__(start_ns, end_ns)
        if line not in ("miso", "mosi"):
            raise ValueError(f"SPI bit errors on line {line!r}; it is 'miso' or 'mosi'")
        self._on_mosi = line == "mosi"
        self._errors = BitErrors(probability, seed, f"{name}.{line}")

    def transaction(self, mosi: Bytes, start_ns: int, end_ns: int) -> bytes:
        """Pass everything on, with errors on one line."""
        if self._on_mosi:
            sent, flipped = self._errors.disturb(bytes(mosi))
            self.fired += flipped
            return self.inner.transaction(sent, start_ns, end_ns)
        miso, flipped = self._errors.disturb(self.inner.transaction(mosi, start_ns, end_ns))
        self.fired += flipped
        return miso


class SpiMissingChip(SpiFault):
    """The chip is not there: it hears nothing and MISO floats to `level`. `fired`: transactions."""

    def __init__(self, start_ns: int, end_ns: int = FAR, level: bool = True) -> None:
        super().__init__(start_ns, end_ns)
        self._fill = b"\xff" if level else b"\x00"

    def transaction(self, mosi: Bytes, start_ns: int, end_ns: int) -> bytes:
        """All ones or all zeros."""
        self.fired += 1
        return self._fill * len(mosi)


class SpiStuckMiso(SpiMissingChip):
    """MISO is stuck at `level`, but the chip hears and obeys. `fired`: transactions."""

    def transaction(self, mosi: Bytes, start_ns: int, end_ns: int) -> bytes:
        """All ones or all zeros."""
        self.inner.transaction(mosi, start_ns, end_ns)
        return super().transaction(mosi, start_ns, end_ns)


class SpiRegisterOverride(SpiFault):
    """One register reads as `value`, alone or in a burst. `fired`: reads of it.

    For chips whose first byte holds a read bit and the address of the first byte that follows. A chip whose
    pointer stays at some register during a burst is read there as if it went on.
    """

    def __init__(
        self,
        start_ns: int,
        end_ns: int,
        register: int,
        value: int,
        read_bit: int = 0x80,
        address_mask: int = 0x7F,
    ) -> None:
        super().__init__(start_ns, end_ns)
        if not 0 <= register <= address_mask or not 0 <= value <= 0xFF:
            raise ValueError(
                f"override of register 0x{register:X} by 0x{value:X}; the register lies in "
                f"0 … 0x{address_mask:X}, the value is one byte"
            )
        self._register = register
        self._value = value
        self._read_bit = read_bit
        self._address_mask = address_mask

    def transaction(self, mosi: Bytes, start_ns: int, end_ns: int) -> bytes:
        """The chip's answer with one byte replaced."""
        miso = self.inner.transaction(mosi, start_ns, end_ns)
        first = mosi[0]
        position = 1 + self._register - (first & self._address_mask)
        if not first & self._read_bit or not 1 <= position < len(miso):
            return miso
        self.fired += 1
        return miso[:position] + bytes((self._value,)) + miso[position + 1 :]


# -- UART ------------------------------------------------------------------------------------------


class UartFault(Fault):
    """On one direction of a serial line."""

    frame_by_frame = False
    breaks_frame = False

    def install(self, wire: UartWire) -> None:
        """Put the fault on `wire` for its time."""
        self._schedule(wire.time, lambda: wire.begin_fault(self), lambda: wire.end_fault(self))

    def sent(self, data: bytes) -> bytes:
        """What the transmitter really queues of `data`."""
        return data

    def frame(self, value: int) -> int | None:
        """What becomes of one byte that begins now; None when it is lost."""
        return value


class UartCut(UartFault):
    """The cable is pulled: the receiver sees an idle line. `fired`: bytes lost, with the one cut through."""

    frame_by_frame = True
    breaks_frame = True

    def frame(self, value: int) -> int | None:
        """Lost."""
        self.fired += 1
        return None


class UartBitErrors(UartFault):
    """Every data bit is flipped with a probability. `fired`: bits flipped."""

    frame_by_frame = True

    def __init__(self, start_ns: int, end_ns: int, probability: float, seed: int, name: str) -> None:
        super().__init__(start_ns, end_ns)
        self._errors = BitErrors(probability, seed, name)

    def frame(self, value: int) -> int | None:
        """The byte with errors."""
        disturbed, flipped = self._errors.disturb(bytes((value,)))
        self.fired += flipped
        return disturbed[0]


class UartTruncation(UartFault):
    """Of each piece that the transmitter queues only the first `keep` bytes leave. `fired`: pieces cut."""

    def __init__(self, start_ns: int, end_ns: int, keep: int) -> None:
        super().__init__(start_ns, end_ns)
        if keep < 0:
            raise ValueError(f"truncation that keeps {keep} bytes; it must be 0 or more")
        self._keep = keep

    def sent(self, data: bytes) -> bytes:
        """The beginning."""
        self.fired += len(data) > self._keep
        return data[: self._keep]


class UartWrongBaud(UartFault):
    """The transmitter sends what is queued meanwhile at another rate. `fired`: bytes sent so."""

    def __init__(self, start_ns: int, end_ns: int, baud: int) -> None:
        super().__init__(start_ns, end_ns)
        if not 0 < baud <= FASTEST_BAUD:
            raise ValueError(f"wrong baud rate {baud}; it must lie in 1 … {FASTEST_BAUD}, e.g. 38400")
        self.forced_baud = baud

    def install(self, wire: UartWire) -> None:
        """Put the fault on `wire` for its time."""

        def begin() -> None:
            wire.forced_baud = self.forced_baud
            wire.begin_fault(self)

        def end() -> None:
            wire.forced_baud = None
            wire.end_fault(self)

        self._schedule(wire.time, begin, end)

    def sent(self, data: bytes) -> bytes:
        """All of it."""
        self.fired += len(data)
        return data


class UartGarbage(UartFault):
    """`length` random bytes at the line's rate drown what is sent meanwhile. `fired`: bytes of noise.

    It ends with its last byte; `lift` only keeps it from beginning.
    """

    frame_by_frame = True
    breaks_frame = True

    def __init__(self, start_ns: int, length: int, seed: int, name: str) -> None:
        super().__init__(start_ns)
        if not 0 < length <= LONGEST_GARBAGE:
            raise ValueError(f"garbage of {length} bytes; there may be 1 … {LONGEST_GARBAGE}, e.g. 500")
        self._length = length
        self._random = np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, *name.encode()])))

    def install(self, wire: UartWire) -> None:
        """Put the noise on `wire`; it ends when the last of its bytes has ended."""

        def begin() -> None:
            wire.begin_fault(self)
            self.fired += self._length
            self.end_ns = wire.inject(self._random.bytes(self._length))
            wire.time.at(self.end_ns, lambda: wire.end_fault(self))

        self._schedule(wire.time, begin, lambda: None)

    def frame(self, value: int) -> int | None:
        """Drowned."""
        return None


# -- CAN -------------------------------------------------------------------------------------------


class CanDisturbance(Fault):
    """The bus is disturbed: no frame gets through. `fired`: attempts that failed."""

    def install(self, bus: EmulatedCanBus) -> None:
        """Put the fault on `bus` for its time."""
        begin, end = bus.begin_disturbance, bus.end_disturbance
        self._schedule(bus.time, lambda: begin(self._strike), lambda: end(self._strike))

    def _strike(self) -> None:
        self.fired += 1
