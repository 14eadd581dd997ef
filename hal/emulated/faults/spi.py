"""Faults between a chip select and its chip."""

from __future__ import annotations

from hal.emulated.faults.chance import BitErrors, Strikes
from hal.emulated.faults.fault import Fault
from hal.emulated.spi import Bytes, EmulatedSpiDevice, SpiSlave
from hal.emulated.virtual_time import FAR


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

    def transaction(self, mosi: Bytes, start_ns: int, end_ns: int) -> Bytes:
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

    def transaction(self, mosi: Bytes, start_ns: int, end_ns: int) -> Bytes:
        """Pass everything on, with errors on one line."""
        if self._on_mosi:
            sent, flipped = self._errors.disturb(bytes(mosi))
            self.fired += flipped
            return self.inner.transaction(sent, start_ns, end_ns)
        miso, flipped = self._errors.disturb(bytes(self.inner.transaction(mosi, start_ns, end_ns)))
        self.fired += flipped
        return miso


class SpiMissingChip(SpiFault):
    """The chip is not there: it hears nothing and MISO floats to `level`. `fired`: transactions."""

    def __init__(self, start_ns: int, end_ns: int = FAR, level: bool = True) -> None:
        super().__init__(start_ns, end_ns)
        self._fill = b"\xff" if level else b"\x00"

    def transaction(self, mosi: Bytes, start_ns: int, end_ns: int) -> Bytes:
        """All ones or all zeros."""
        self.fired += 1
        return self._fill * len(mosi)


class SpiStuckMiso(SpiMissingChip):
    """MISO is stuck at `level`, but the chip hears and obeys. `fired`: transactions."""

    def transaction(self, mosi: Bytes, start_ns: int, end_ns: int) -> Bytes:
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

    def transaction(self, mosi: Bytes, start_ns: int, end_ns: int) -> Bytes:
        """The chip's answer with one byte replaced."""
        miso = self.inner.transaction(mosi, start_ns, end_ns)
        first = mosi[0]
        position = 1 + self._register - (first & self._address_mask)
        if not first & self._read_bit or not 1 <= position < len(miso):
            return miso
        self.fired += 1
        return miso[:position] + bytes((self._value,)) + miso[position + 1 :]


class SpiWordSlip(SpiFault):
    """Chip and controller disagree on where a word begins: the answer comes `bits` clocks late.

    What the chip still had to say appears at the beginning of the next answer; 16 bits are a whole word of a
    chip with 16-bit words. The chip hears rightly. `fired`: transactions.
    """

    def __init__(self, start_ns: int, end_ns: int = FAR, bits: int = 1) -> None:
        super().__init__(start_ns, end_ns)
        if not 1 <= bits <= 64:
            raise ValueError(f"word slip of {bits} bits; it must lie in 1 … 64, e.g. 16")
        self._bits = bits
        self._rest = (1 << bits) - 1

    def transaction(self, mosi: Bytes, start_ns: int, end_ns: int) -> Bytes:
        """The answer behind the end of the one before."""
        self.fired += 1
        bits = 8 * len(mosi)
        answer = int.from_bytes(self.inner.transaction(mosi, start_ns, end_ns), "big")
        line = self._rest << bits | answer
        self._rest = line & (1 << self._bits) - 1
        return (line >> self._bits & (1 << bits) - 1).to_bytes(len(mosi), "big")


class SpiLateAnswers(SpiFault):
    """Every transaction gets the answer of the one before of its length; the first gets all ones. `fired`:
    transactions."""

    def __init__(self, start_ns: int, end_ns: int = FAR) -> None:
        super().__init__(start_ns, end_ns)
        self._answers: dict[int, bytes] = {}

    def transaction(self, mosi: Bytes, start_ns: int, end_ns: int) -> Bytes:
        """What was said last time."""
        self.fired += 1
        late = self._answers.get(len(mosi), b"\xff" * len(mosi))
        self._answers[len(mosi)] = bytes(self.inner.transaction(mosi, start_ns, end_ns))
        return late


class SpiByteSlips(SpiFault):
    """Bytes of the answer are lost or come twice, each with a probability; those behind move up or back, and
    0xFF fills the end. `fired`: bytes."""

    def __init__(
        self, start_ns: int, end_ns: int, probability: float, seed: int, name: str, doubled: bool = False
    ) -> None:
        super().__init__(start_ns, end_ns)
        self._strikes = Strikes(probability, seed, name)
        self._copies = 2 if doubled else 0

    def transaction(self, mosi: Bytes, start_ns: int, end_ns: int) -> Bytes:
        """The chip's answer with bytes lost or doubled."""
        answer = self.inner.transaction(mosi, start_ns, end_ns)
        taken = bytearray()
        for value in answer:
            struck = self._strikes.next()
            self.fired += struck
            taken += bytes((value,)) * (self._copies if struck else 1)
        return bytes(taken[: len(answer)]).ljust(len(answer), b"\xff")
