"""Faults: what they do, exactly when, and that they say how often."""

import numpy as np
import pytest
from emulated_benches import Collector, Complementing, processor
from hypothesis import given, settings
from hypothesis import strategies as st

from hal.can import CanFrame
from hal.emulated.can import CanNode, EmulatedCanBus, EmulatedCanController
from hal.emulated.faults import (
    CanDisturbance,
    Fault,
    SpiBitErrors,
    SpiMissingChip,
    SpiRegisterOverride,
    SpiStuckMiso,
    UartBitErrors,
    UartCut,
    UartFault,
    UartGarbage,
    UartTruncation,
    UartWrongBaud,
)
from hal.emulated.spi import EmulatedSpiBus, EmulatedSpiDevice, SpiTiming
from hal.emulated.uart import EmulatedUart, UartWire
from hal.emulated.uart_bytes import SentBytes, sample
from hal.emulated.virtual_time import FAR, SECOND, VirtualTime

MS = 1_000_000


def spi() -> EmulatedSpiDevice:
    """One byte takes 8 µs."""
    return EmulatedSpiBus(processor(), SpiTiming(1_000_000)).device(Complementing())


def exchange(device: EmulatedSpiDevice, data: bytes) -> bytes:
    buffer = bytearray(data)
    device.transaction(buffer)
    return bytes(buffer)


class Registers:
    """SPI slave with 128 registers that hold their own address; remembers what it heard."""

    def __init__(self) -> None:
        self.heard: list[bytes] = []

    def transaction(self, mosi: bytes | bytearray, start_ns: int, end_ns: int) -> bytes:
        self.heard.append(bytes(mosi))
        return bytes([0, *((mosi[0] & 0x7F) + n & 0x7F for n in range(len(mosi) - 1))])


def test_missing_chip_hears_nothing_within_its_time_only() -> None:
    device = spi()
    chip = Registers()
    device.slave = chip
    fault = SpiMissingChip(start_ns=20_000, end_ns=60_000, level=False)
    fault.install(device)
    answers = [exchange(device, b"\x85\x00") for _ in range(5)]
    assert answers == [b"\x00\x05", b"\x00\x05", b"\x00\x00", b"\x00\x00", b"\x00\x05"]
    assert len(chip.heard) == 3
    assert fault.fired == 2
    assert device.slave is chip


def test_stuck_miso_leaves_the_chip_listening() -> None:
    device = spi()
    chip = Registers()
    device.slave = chip
    fault = SpiStuckMiso(start_ns=0, level=True)
    fault.install(device)
    assert exchange(device, b"\x85\x00") == b"\xff\xff", "a fault from 0 on is there at 0"
    assert chip.heard == [b"\x85\x00"]
    assert fault.fired == 1


def test_register_override_in_a_burst_and_alone() -> None:
    device = spi()
    device.slave = Registers()
    fault = SpiRegisterOverride(start_ns=0, end_ns=SECOND, register=0x0E, value=0xEE)
    fault.install(device)
    assert exchange(device, b"\x8c" + bytes(4)) == bytes([0, 0x0C, 0x0D, 0xEE, 0x0F])
    assert exchange(device, b"\x8e\x00") == b"\x00\xee"
    assert exchange(device, b"\x8f\x00") == b"\x00\x0f"
    assert exchange(device, b"\x8c" + bytes(2)) == bytes([0, 0x0C, 0x0D])
    assert exchange(device, b"\x0e\x00") == b"\x00\x0e", "a write is not overridden"
    assert fault.fired == 2


def test_faults_on_one_device_overlap_and_leave_in_any_order() -> None:
    device = spi()
    chip = Registers()
    device.slave = chip
    first = SpiRegisterOverride(start_ns=0, end_ns=40_000, register=1, value=0xAA)
    second = SpiRegisterOverride(start_ns=20_000, end_ns=80_000, register=2, value=0xBB)
    first.install(device)
    second.install(device)
    answers = [exchange(device, b"\x81\x00\x00")[1:] for _ in range(4)]
    assert answers == [b"\xaa\x02", b"\xaa\xbb", b"\x01\xbb", b"\x01\xbb"]
    device.bus.cpu.delay(20_000)
    assert device.slave is chip


@pytest.mark.parametrize("line", ["miso", "mosi"])
def test_spi_bit_errors_have_their_probability_and_are_repeatable(line: str) -> None:
    counts, answers = [], []
    for _ in range(2):
        device = spi()
        fault = SpiBitErrors(0, FAR, probability=1e-2, seed=7, name="imu", line=line)
        fault.install(device)
        answers.append([exchange(device, bytes(50)) for _ in range(400)])
        counts.append(fault.fired)
    assert answers[0] == answers[1]
    wrong = sum(bin(byte ^ 0xFF).count("1") for answer in answers[0] for byte in answer)
    assert wrong == counts[0]
    expected = 400 * 400 * 1e-2
    assert abs(counts[0] - expected) < 5 * np.sqrt(expected)


def test_bit_errors_of_one_name_do_not_depend_on_another() -> None:
    def flipped(name: str, others: int) -> list[bytes]:
        device = spi()
        for n in range(others):
            SpiBitErrors(0, FAR, 0.0, seed=7, name=f"other {n}").install(device)
        SpiBitErrors(0, FAR, 0.01, seed=7, name=name).install(device)
        return [exchange(device, bytes(50)) for _ in range(20)]

    assert flipped("imu", 0) == flipped("imu", 3)
    assert flipped("imu", 0) != flipped("baro", 0)


# -- UART: 9600 baud, one byte takes 1.041666 ms -----------------------------------------------------


class Line:
    """A wire with a processor's port and a tap at its far end."""

    def __init__(self, fault: UartFault | None, baud: int = 9600) -> None:
        self.cpu = processor("rx")
        self.time: VirtualTime = self.cpu.time
        self.wire = UartWire(self.time, baud, "gnss")
        self.tap = Collector()
        self.wire.connect(self.tap)
        back = UartWire(self.time, baud, "back", capacity=64)
        self.port = EmulatedUart(self.cpu, back, self.wire)
        self.ring = bytearray(1024)
        self.interrupts: list[int] = []
        line = self.cpu.attach("rx", lambda: self.interrupts.append(self.time.now - 72))
        self.port.start_receive(self.ring, line)
        if fault is not None:
            fault.install(self.wire)

    def run(self, until: int = SECOND) -> bytes:
        self.cpu.wait_until(until)
        return bytes(self.ring[: self.port.received()])


def byte_end(count: int, baud: int = 9600) -> int:
    return count * 10 * SECOND // baud


def test_cut_loses_the_byte_under_way_and_those_that_begin_meanwhile() -> None:
    """From the middle of byte 10 to the middle of byte 15 (counted from 0): 10 … 15 are lost."""
    start, end = byte_end(10) + 500_000, byte_end(15) + 500_000
    fault = UartCut(start, end)
    line = Line(fault)
    line.wire.send(bytes(range(40)))
    received = line.run()
    assert received == bytes(range(10)) + bytes(range(16, 40))
    assert line.tap.data == received
    assert fault.fired == 6
    assert line.interrupts == [byte_end(10) + byte_end(1), byte_end(40) + byte_end(1)], "idle during the cut"


def test_cut_of_an_idle_line_does_nothing() -> None:
    fault = UartCut(100 * MS, 200 * MS)
    line = Line(fault)
    line.wire.send(b"before")
    line.time.at(250 * MS, lambda: line.wire.send(b"after") and None)
    assert line.run() == b"beforeafter"
    assert fault.fired == 0
    assert line.interrupts == [byte_end(7), 250 * MS + byte_end(5) + byte_end(1)]


def test_line_goes_back_to_few_events_after_a_fault() -> None:
    line = Line(UartCut(0, 10 * MS))
    line.wire.send(bytes(100))
    line.cpu.wait_until(500 * MS)
    before = line.time.events_run
    line.wire.send(bytes(300))
    line.cpu.wait_until(SECOND)
    assert line.time.events_run - before <= 4


def test_uart_bit_errors_count_their_flips() -> None:
    fault = UartBitErrors(0, FAR, probability=0.01, seed=3, name="gnss")
    line = Line(fault)
    line.time.at(0, lambda: line.wire.send(bytes(900)) and None)
    received = line.run(until=SECOND)
    assert len(received) == 900
    flips = sum(bin(byte).count("1") for byte in received)
    assert flips == fault.fired
    assert 72 - 5 * 8.5 < flips < 72 + 5 * 8.5


def test_truncation_keeps_the_beginning_of_each_piece() -> None:
    fault = UartTruncation(10 * MS, 300 * MS, keep=4)
    line = Line(fault)
    for at, text in [
        (0, b"whole one "),
        (50 * MS, b"cut here "),
        (100 * MS, b"abc"),
        (400 * MS, b" whole again"),
    ]:
        line.time.at(at, lambda text=text: line.wire.send(text) and None)  # type: ignore[misc]
    assert line.run() == b"whole one cut abc whole again"
    assert fault.fired == 1


def test_wrong_baud_is_garbage_with_framing_errors() -> None:
    fault = UartWrongBaud(100 * MS, 200 * MS, baud=4800)
    line = Line(fault)
    line.wire.send(b"good ")
    line.time.at(150 * MS, lambda: line.wire.send(b"$GN") and None)
    line.time.at(300 * MS, lambda: line.wire.send(b"good") and None)
    received = line.run()
    found = sample([SentBytes(b"$GN", 150 * MS, 0, 4800)], 9600, 0)
    assert received == b"good " + b"".join(one.data for one in found) + b"good"
    assert line.port.take_errors() == sum(one.errors for one in found) > 0
    assert fault.fired == 3


def test_garbage_drowns_what_is_sent_meanwhile() -> None:
    fault = UartGarbage(byte_end(5), length=10, seed=1, name="gnss")
    line = Line(fault)
    line.wire.send(b"0123456789abcdefghijklmnop")
    received = line.run()
    assert received[:5] == b"01234"
    assert received[15:] == b"fghijklmnop"
    assert fault.fired == 10
    again = Line(UartGarbage(byte_end(5), length=10, seed=1, name="gnss"))
    again.wire.send(b"0123456789abcdefghijklmnop")
    assert again.run() == received


def test_garbage_on_an_idle_line_arrives_by_itself() -> None:
    fault = UartGarbage(100 * MS, length=32, seed=1, name="gnss")
    line = Line(fault)
    received = line.run()
    assert len(received) == 32
    assert len(set(received)) > 20
    assert line.interrupts == [100 * MS + byte_end(32) + byte_end(1)]


def test_installed_in_the_middle_of_a_burst_it_takes_effect_from_then_on() -> None:
    line = Line(None)
    fault = UartBitErrors(0, FAR, probability=1.0, seed=1, name="gnss")
    line.wire.send(bytes(20))
    line.cpu.wait_until(byte_end(8) + 300_000)
    fault.install(line.wire)
    received = line.run()
    assert received == bytes(9) + b"\xff" * 11, "the byte under way had begun"
    assert fault.fired == 88


def test_faults_add_up() -> None:
    cut = UartCut(byte_end(10), byte_end(20))
    errors = UartBitErrors(0, FAR, probability=1.0, seed=1, name="gnss")
    line = Line(cut)
    errors.install(line.wire)
    line.time.at(0, lambda: line.wire.send(bytes(30)) and None)
    assert line.run() == b"\xff" * 20
    assert cut.fired == 10


# --------------------------------------------------------------------------------------------------------


def test_can_disturbance_counts_what_it_broke() -> None:
    cpu = processor()
    bus = EmulatedCanBus(cpu.time, 500_000)
    mcu = EmulatedCanController(cpu, bus)
    CanNode(bus)
    received: list[int] = []
    bus.listen(lambda frame, _end: received.append(frame.identifier))
    fault = CanDisturbance(MS, 2 * MS)
    fault.install(bus)
    for n in range(5):
        cpu.time.at(n * 700_000, lambda n=n: mcu.send((CanFrame(n, b""),)) and None)  # type: ignore[misc]
    cpu.delay(100 * MS)
    assert received == [0, 1, 2, 3, 4]
    assert fault.fired == bus.error_frames > 5


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: UartCut(10, 10), "fault from 10 ns to 10 ns"),
        (lambda: SpiBitErrors(0, 1, 1.5, 1, "x"), r"probability 1\.5; it must lie in 0 … 1"),
        (lambda: SpiBitErrors(0, 1, 0.5, 1, "x", line="sck"), "line 'sck'; it is 'miso' or 'mosi'"),
        (lambda: SpiRegisterOverride(0, 1, 0x80, 0), "override of register 0x80 by 0x0"),
        (lambda: UartTruncation(0, 1, -1), "keeps -1 bytes"),
        (lambda: UartWrongBaud(0, 1, 0), "wrong baud rate 0"),
        (lambda: UartWrongBaud(0, 1, 10**12), "it must lie in 1 … 100000000"),
        (lambda: UartGarbage(0, 0, 1, "x"), "garbage of 0 bytes"),
        (lambda: UartGarbage(0, 10**30, 1, "x"), "there may be 1 … 10000000"),
    ],
)
def test_impossible_faults_are_refused(make: "type[Fault]", message: str) -> None:
    with pytest.raises(ValueError, match=message):
        make()  # type: ignore[call-arg]


def test_fault_in_the_past_is_refused() -> None:
    line = Line(None)
    line.cpu.wait_until(MS)
    with pytest.raises(ValueError, match="fault ends at 5 ns, which has passed"):
        UartCut(0, 5).install(line.wire)


@settings(max_examples=50, deadline=None)
@given(
    st.lists(st.tuples(st.integers(0, 40 * MS), st.binary(min_size=1, max_size=30)), min_size=1, max_size=6),
    st.lists(st.tuples(st.integers(0, 90 * MS), st.integers(1, 40 * MS)), max_size=3),
    st.sampled_from([9600, 9700, 19_200]),
)
def test_byte_by_byte_and_at_once_are_the_same(
    sends: list[tuple[int, bytes]], windows: list[tuple[int, int]], baud: int
) -> None:
    """A fault that changes nothing makes the line go byte by byte: same bytes, instants and interrupts, also
    when the receiver samples at another rate."""
    seen = []
    for with_faults in (False, True):
        line = Line(None)
        line.port.set_baud(baud)
        for at, data in sorted(sends):
            line.time.at(at, lambda data=data, line=line: line.wire.send(data) and None)  # type: ignore[misc]
        if with_faults:
            for n, (start, length) in enumerate(windows):
                UartBitErrors(start, start + length, 0.0, seed=n, name="none").install(line.wire)
        received = line.run()
        seen.append((received, line.tap.data, line.interrupts, line.port.take_errors(), line.wire.busy_ns))
    assert seen[0] == seen[1]
