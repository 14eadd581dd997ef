"""Faults of I²C, late and slipped SPI answers, bytes lost and doubled, framing, overrun, stuck nets."""

from __future__ import annotations

import numpy as np
import pytest
from emulated_benches import Collector, processor

from hal.emulated.cpu import EmulatedCpu
from hal.emulated.faults import (
    I2cBitErrors,
    I2cClockStretch,
    I2cNack,
    I2cStuckLine,
    PinStuck,
    SpiByteSlips,
    SpiLateAnswers,
    SpiWordSlip,
    UartByteDuplication,
    UartByteLoss,
    UartFramingErrors,
    UartOverrun,
    UartParity,
)
from hal.emulated.i2c import EmulatedI2cBus
from hal.emulated.pins import Net
from hal.emulated.spi import EmulatedSpiBus, SpiTiming
from hal.emulated.uart import EmulatedUart, UartWire
from hal.emulated.virtual_time import FAR, SECOND, VirtualTime
from hal.errors import BusError, ErrorKind

MS = 1_000_000


class Memory:
    """I²C slave: remembers what was written, gives counting bytes."""

    def __init__(self) -> None:
        self.heard: list[bytes] = []

    def write(self, data: bytes, time_ns: int) -> int:
        self.heard.append(data)
        return len(data)

    def read(self, length: int, time_ns: int) -> bytes:
        return bytes(range(length))


def i2c() -> tuple[EmulatedI2cBus, Memory, EmulatedCpu]:
    cpu = processor()
    bus = EmulatedI2cBus(cpu, 100_000, "i2c1")
    bus.attach(0x19, memory := Memory())
    bus.attach(0x1D, Memory())
    return bus, memory, cpu


def refused(
    bus: EmulatedI2cBus, address: int = 0x19, write: bytes = b"\x50", length: int = 0
) -> ErrorKind | None:
    try:
        bus.transaction(address, write, length)
    except BusError as error:
        return error.kind
    return None


def test_i2c_address_not_acknowledged_within_its_time_only() -> None:
    bus, memory, cpu = i2c()
    fault = I2cNack(1 * MS, 2 * MS)
    fault.install(bus, 0x19)
    kinds = []
    for _ in range(6):
        kinds.append(refused(bus))
        cpu.delay(400_000)
    assert [kind is ErrorKind.ADDRESS_NACK for kind in kinds].count(True) == fault.fired > 0
    assert kinds[0] is None
    assert kinds[-1] is None
    assert bus.slave(0x19) is memory


def test_i2c_byte_not_acknowledged() -> None:
    bus, memory, _ = i2c()
    fault = I2cNack(0, FAR, byte=1)
    fault.install(bus, 0x19)
    assert refused(bus, write=b"\xf1\x04\x11") is ErrorKind.DATA_NACK
    assert refused(bus, write=b"\x50") is None
    assert memory.heard == [b"\xf1", b"\x50"]
    assert fault.fired == 1


@pytest.mark.parametrize("line", ["read", "write"])
def test_i2c_bit_errors(line: str) -> None:
    bus, memory, _ = i2c()
    fault = I2cBitErrors(0, FAR, 1e-2, seed=1, name="compass", line=line)
    fault.install(bus, 0x19)
    wrong = 0
    for _ in range(200):
        data = bus.transaction(0x19, bytes(50), 50)
        wrong += sum((a ^ b).bit_count() for a, b in zip(data, range(50), strict=True))
    wrong += sum(byte.bit_count() for data in memory.heard for byte in data)
    assert wrong == fault.fired
    assert abs(fault.fired - 800) < 5 * np.sqrt(800)


def test_i2c_late_answer() -> None:
    bus, _, _ = i2c()
    bus.transaction(0x19, b"\x50", 6)
    usual = bus.time.now
    I2cClockStretch(bus.time.now, FAR, hold_ms=2.0).install(bus, 0x19)
    begin = bus.time.now
    bus.transaction(0x19, b"\x50", 6)
    assert bus.time.now - begin == usual + 2 * 2 * MS, "behind each of the two addresses"
    too_long = I2cClockStretch(bus.time.now, FAR, hold_ms=30.0)
    too_long.install(bus, 0x19)
    assert refused(bus) is ErrorKind.TIMEOUT
    assert refused(bus, 0x1D) is None, "another chip is as ever"


@pytest.mark.parametrize(
    ("line", "level", "kind"),
    [
        ("sda", False, ErrorKind.TIMEOUT),
        ("scl", False, ErrorKind.TIMEOUT),
        ("scl", True, ErrorKind.TIMEOUT),
        ("sda", True, ErrorKind.ADDRESS_NACK),
    ],
)
def test_i2c_stuck_line_holds_for_every_chip(line: str, level: bool, kind: ErrorKind) -> None:
    bus, memory, cpu = i2c()
    fault = I2cStuckLine(0, 100 * MS, line=line, level=level)
    fault.install(bus)
    for address in (0x19, 0x1D, 0x70):
        begin = bus.time.now
        assert refused(bus, address) is kind
        if kind is ErrorKind.TIMEOUT:
            assert bus.time.now - begin == bus.stretch_limit_ns
    assert fault.fired == 3
    assert memory.heard == []
    cpu.delay(100 * MS)
    assert refused(bus) is None


def test_i2c_faults_leave_in_any_order() -> None:
    bus, memory, _ = i2c()
    first, second = I2cNack(0, FAR, byte=5), I2cBitErrors(0, FAR, 0.0, 1, "x")
    first.install(bus, 0x19)
    second.install(bus, 0x19)
    first.lift()
    assert refused(bus, write=bytes(9)) is None
    second.lift()
    assert bus.slave(0x19) is memory
    with pytest.raises(ValueError, match="nobody at 0x22"):
        I2cNack(0, FAR).install(bus, 0x22)


# -- SPI -------------------------------------------------------------------------------------------


class Counting:
    """SPI slave whose answers count up."""

    def __init__(self) -> None:
        self.calls = 0

    def transaction(self, mosi: bytes | bytearray, start_ns: int, end_ns: int) -> bytes:
        self.calls += 1
        return bytes((16 * self.calls + k) & 0xFF for k in range(len(mosi)))


def spi(fault: object) -> list[bytes]:
    """Answers of two bytes to six transactions of 16 µs each, the fault from the third to the fourth."""
    device = EmulatedSpiBus(processor(), SpiTiming(1_000_000)).device(Counting())
    fault.install(device)  # type: ignore[attr-defined]
    answers = []
    for _ in range(6):
        buffer = bytearray(2)
        device.transaction(buffer)
        answers.append(bytes(buffer))
    return answers


def test_spi_answers_slip_by_bits_and_by_a_word() -> None:
    assert spi(SpiWordSlip(32_000, 64_000, bits=8)) == [
        b"\x10\x11", b"\x20\x21", b"\xff\x30", b"\x31\x40", b"\x50\x51", b"\x60\x61"
    ]  # fmt: skip
    assert spi(SpiWordSlip(32_000, 64_000, bits=16))[2:4] == [b"\xff\xff", b"\x30\x31"]
    one = spi(SpiWordSlip(32_000, 64_000, bits=1))[2]
    assert int.from_bytes(one, "big") == 0x8000 | 0x3031 >> 1


def test_spi_answers_come_a_transaction_late() -> None:
    late = SpiLateAnswers(32_000, 64_000)
    assert spi(late)[2:5] == [b"\xff\xff", b"\x30\x31", b"\x50\x51"]
    assert late.fired == 2


@pytest.mark.parametrize("doubled", [False, True])
def test_spi_bytes_slip(doubled: bool) -> None:
    fault = SpiByteSlips(0, FAR, 1.0, 1, "imu", doubled=doubled)
    assert spi(fault)[0] == (b"\x10\x10" if doubled else b"\xff\xff")
    assert fault.fired == 12
    rare = SpiByteSlips(0, FAR, 0.3, 1, "imu")
    assert spi(rare) != spi(SpiByteSlips(0, FAR, 0.3, 2, "imu"))
    assert spi(SpiByteSlips(0, FAR, 0.0, 1, "imu"))[0] == b"\x10\x11"


# -- UART ------------------------------------------------------------------------------------------


class Line:
    """A wire into a port, with a tap."""

    def __init__(self) -> None:
        self.cpu = processor("rx")
        self.time: VirtualTime = self.cpu.time
        self.wire = UartWire(self.time, 9600, "gnss")
        self.tap = Collector()
        self.wire.connect(self.tap)
        self.port = EmulatedUart(self.cpu, UartWire(self.time, 9600, "back", capacity=64), self.wire)
        self.ring = bytearray(4096)
        self.port.start_receive(self.ring, self.cpu.attach("rx", lambda: None))

    def send(self, data: bytes) -> bytes:
        """What the port receives of it."""
        before = self.port.received()
        self.wire.send(data)
        self.cpu.delay(len(data) * 3 * MS)
        return bytes(self.ring[before : self.port.received()])


TEXT = bytes(range(32, 127)) * 5


def test_bytes_are_lost() -> None:
    line = Line()
    fault = UartByteLoss(0, FAR, 0.1, 1, "gnss")
    fault.install(line.wire)
    got = line.send(TEXT)
    assert len(got) == len(TEXT) - fault.fired
    assert 20 < fault.fired < 80
    rest = iter(TEXT)
    assert all(value in rest for value in got), "in their order"
    assert line.port.take_errors() == 0


def test_bytes_come_twice() -> None:
    line = Line()
    fault = UartByteDuplication(0, FAR, 0.1, 1, "gnss")
    fault.install(line.wire)
    got = line.send(TEXT)
    assert len(got) == len(TEXT) + fault.fired
    assert 20 < fault.fired < 80


def test_framing_errors_are_told_and_the_byte_is_there() -> None:
    line = Line()
    fault = UartFramingErrors(0, 1_400 * MS, 0.1, 1, "gnss")
    fault.install(line.wire)
    assert line.send(TEXT) == TEXT
    assert line.port.take_errors() == fault.fired > 20
    assert line.send(TEXT) == TEXT
    assert line.port.take_errors() == 0


def test_parity_is_taken_for_the_stop_bit() -> None:
    line = Line()
    fault = UartParity(0, FAR)
    fault.install(line.wire)
    assert line.send(TEXT) == TEXT
    even = sum(value.bit_count() % 2 == 0 for value in TEXT)
    assert line.port.take_errors() == fault.fired == even


def test_bytes_with_parity_have_eleven_bits() -> None:
    """What is queued once the fault has passed has ten again."""
    line = Line()
    fault = UartParity(0, 50 * MS)
    fault.install(line.wire)
    line.wire.send(b"UUUU")
    assert line.wire.idle_from == 44 * SECOND // 9600
    line.cpu.delay(60 * MS)
    line.wire.send(b"UUUU")
    assert line.wire.idle_from - line.cpu.time.now == 40 * SECOND // 9600


def test_overrun_bytes_are_on_the_line() -> None:
    """Who else listens hears them."""
    line = Line()
    tap = line.wire.connect_late()
    fault = UartOverrun(0, FAR, 0.5, 1, "gnss")
    fault.install_at(line.port)
    got = line.send(TEXT)
    assert b"".join(data for data, _end, _baud in tap.pieces()) == TEXT
    assert len(got) == len(TEXT) - fault.fired


def test_overruns_lose_bytes_and_are_told() -> None:
    line = Line()
    fault = UartOverrun(0, FAR, 0.1, 1, "gnss")
    fault.install_at(line.port)
    got = line.send(TEXT)
    assert line.port.take_errors() == fault.fired == len(TEXT) - len(got) > 20


@pytest.mark.parametrize("probability", [-0.1, 1.1])
def test_probabilities_are_probabilities(probability: float) -> None:
    with pytest.raises(ValueError, match="0 … 1"):
        UartByteLoss(0, FAR, probability, 1, "x")


# -- pins ------------------------------------------------------------------------------------------


def test_a_stuck_net_shows_nothing_and_comes_back_to_its_driver() -> None:
    cpu = processor()
    net = Net(cpu.time, "DRDY")
    seen: list[tuple[bool, int]] = []
    net.listen(lambda level, time_ns: seen.append((level, time_ns)))
    fault = PinStuck(10 * MS, 20 * MS)
    fault.install(net)
    for k in range(30):
        cpu.time.at(k * MS + 500_000, lambda k=k: net.set(k % 2 == 0))  # type: ignore[misc]
    cpu.delay(40 * MS)
    times = [time_ns // MS for _, time_ns in seen]
    assert not [t for t in times if 10 < t < 20]
    assert fault.fired == 10
    assert [t for t in times if t >= 20][:2] == [20, 21] or times.count(20) == 2
    assert net.holder is None


def test_a_net_stuck_high_and_a_second_fault_on_it() -> None:
    cpu = processor()
    net = Net(cpu.time, "PPS")
    high = PinStuck(0, 50 * MS, level=True)
    second = PinStuck(10 * MS, 20 * MS, level=False)
    high.install(net)
    second.install(net)
    assert net.level
    cpu.delay(30 * MS)
    assert net.level, "the first holds it"
    net.set(True)
    cpu.delay(30 * MS)
    assert net.level, "what its driver wants now"
