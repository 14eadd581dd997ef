"""Faults on one direction of a serial line."""

from __future__ import annotations

from hal.emulated.faults.chance import BitErrors, Strikes, generator
from hal.emulated.faults.fault import Fault
from hal.emulated.uart import EmulatedUart
from hal.emulated.uart_bytes import NO_STOP_BIT, NOT_TAKEN, ParityFrames, SentBytes, even_bytes
from hal.emulated.uart_wire import UartWire

FASTEST_BAUD = 100_000_000
LONGEST_GARBAGE = 10_000_000
"""Bytes; a quarter of an hour at 115,200 baud."""


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
        self._random = generator(seed, name)

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


class UartByteLoss(UartFault):
    """Every byte is lost with a probability. `fired`: bytes lost."""

    frame_by_frame = True

    def __init__(self, start_ns: int, end_ns: int, probability: float, seed: int, name: str) -> None:
        super().__init__(start_ns, end_ns)
        self._strikes = Strikes(probability, seed, name)

    def frame(self, value: int) -> int | None:
        """Lost, or not."""
        struck = self._strikes.next()
        self.fired += struck
        return None if struck else value


class UartByteDuplication(UartFault):
    """Every byte is queued twice with a probability. `fired`: bytes that came twice."""

    def __init__(self, start_ns: int, end_ns: int, probability: float, seed: int, name: str) -> None:
        super().__init__(start_ns, end_ns)
        self._strikes = Strikes(probability, seed, name)

    def sent(self, data: bytes) -> bytes:
        """With the doubles."""
        queued = bytearray()
        for value in data:
            struck = self._strikes.next()
            self.fired += struck
            queued += bytes((value,)) * (1 + struck)
        return bytes(queued)


class UartFramingErrors(UartFault):
    """The stop bit of a byte is low with a probability: it is received, with a framing error. `fired`:
    bytes."""

    frame_by_frame = True

    def __init__(self, start_ns: int, end_ns: int, probability: float, seed: int, name: str) -> None:
        super().__init__(start_ns, end_ns)
        self._strikes = Strikes(probability, seed, name)

    def frame(self, value: int) -> int | None:
        """With a low stop bit, or not."""
        struck = self._strikes.next()
        self.fired += struck
        return value | NO_STOP_BIT if struck else value


class UartParity(UartFault):
    """The transmitter adds a bit of even parity to what is queued meanwhile: the receiver, which expects
    none, takes it for the stop bit, so every byte with an even number of ones has a framing error.
    `fired`: those bytes."""

    def install(self, wire: UartWire) -> None:
        """Put the fault on `wire` for its time."""

        def begin() -> None:
            wire.form = ParityFrames
            wire.begin_fault(self)

        def end() -> None:
            wire.form = SentBytes
            wire.end_fault(self)

        self._schedule(wire.time, begin, end)

    def sent(self, data: bytes) -> bytes:
        """All of it."""
        self.fired += even_bytes(data)
        return data


class UartOverrun(UartFault):
    """The port does not take a byte in time, with a probability: the byte is lost and the port says so.
    `fired`: bytes lost."""

    frame_by_frame = True

    def __init__(self, start_ns: int, end_ns: int, probability: float, seed: int, name: str) -> None:
        super().__init__(start_ns, end_ns)
        self._strikes = Strikes(probability, seed, name)

    def install_at(self, port: EmulatedUart) -> None:
        """Put the fault at the receiving end of `port` for its time."""
        self.install(port.rx)

    def frame(self, value: int) -> int | None:
        """Missed, or not."""
        struck = self._strikes.next()
        self.fired += struck
        return value | NOT_TAKEN if struck else value
