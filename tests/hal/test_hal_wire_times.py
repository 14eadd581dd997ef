"""Wire times against the tables of the timing fact sheet."""

import pytest
from emulated_benches import Collector, Complementing, RegisterSlave, processor
from hypothesis import given
from hypothesis import strategies as st

from hal.emulated.i2c import EmulatedI2cBus
from hal.emulated.spi import EmulatedSpiBus, SpiTiming
from hal.emulated.uart import UartWire
from hal.emulated.virtual_time import SECOND, VirtualTime
from hal.errors import BusError

SPI_TABLE = [
    ("ADXL345 6 data bytes", 7, SpiTiming(5_000_000), 11_200),
    ("ADXL345 6 data bytes", 7, SpiTiming(2_000_000), 28_000),
    ("ADXL345 6 data bytes", 7, SpiTiming(1_000_000), 56_000),
    ("BMI160 12 bytes", 13, SpiTiming(10_000_000), 10_400),
    ("BMI160 12 bytes", 13, SpiTiming(5_000_000), 20_800),
    ("BMI160 12 bytes", 13, SpiTiming(2_000_000), 52_000),
    ("ADIS16407 burst", 30, SpiTiming(1_000_000, bits_per_word=16, stall_clocks=1), 254_000),
    ("ADIS16407 word", 2, SpiTiming(2_000_000, bits_per_word=16), 8_000),
    ("ADIS16407 eleven words", 22, SpiTiming(2_000_000, bits_per_word=16, stall_ns=9_000), 178_000),
]


@pytest.mark.parametrize(("what", "length", "timing", "expected_ns"), SPI_TABLE)
def test_spi_transaction_takes_its_time(what: str, length: int, timing: SpiTiming, expected_ns: int) -> None:
    cpu = processor()
    device = EmulatedSpiBus(cpu, timing).device(Complementing())
    device.transaction(bytearray(length))
    assert cpu.time.now == expected_ns, what


def test_spi_clock_that_does_not_divide_a_ns() -> None:
    """16 bytes at 5.25 MHz: 24 380.95 ns; a thousand transactions lose nothing but their own fraction."""
    cpu = processor()
    bus = EmulatedSpiBus(cpu, SpiTiming(5_250_000, setup_ns=100, hold_ns=50))
    device = bus.device(Complementing())
    for _ in range(1000):
        device.transaction(bytearray(16))
    assert cpu.time.now == 1000 * (24_380 + 150)
    assert bus.transactions == 1000
    assert bus.busy_ns == cpu.time.now


def test_spi_select_stays_high_between_transactions() -> None:
    """5 µs between reads of a FIFO; a gap that has passed already costs nothing."""
    cpu = processor()
    device = EmulatedSpiBus(cpu, SpiTiming(1_000_000, high_ns=5_000)).device(Complementing())
    seen: list[tuple[int, int]] = []
    device.observer = lambda start, end, _mosi, _miso: seen.append((start, end))
    device.transaction(bytearray(1))
    device.transaction(bytearray(1))
    cpu.delay(20_000)
    device.transaction(bytearray(1))
    assert seen == [(0, 8_000), (13_000, 21_000), (41_000, 49_000)]


def test_spi_half_words_are_refused() -> None:
    device = EmulatedSpiBus(processor(), SpiTiming(1_000_000, bits_per_word=16)).device(Complementing())
    with pytest.raises(ValueError, match="SPI transaction of 3 bytes; with words of 16 bits"):
        device.transaction(bytearray(3))
    with pytest.raises(ValueError, match="SPI transaction of 0 bytes"):
        device.transaction(bytearray(0))


def test_spi_interrupt_on_the_same_bus_waits_for_the_wire() -> None:
    cpu = processor("urgent")
    bus = EmulatedSpiBus(cpu, SpiTiming(1_000_000))
    slow, quick = bus.device(Complementing(), "slow"), bus.device(Complementing(), "quick")
    seen: list[tuple[str, int, int]] = []
    slow.observer = lambda start, end, _mosi, _miso: seen.append(("slow", start, end))
    quick.observer = lambda start, end, _mosi, _miso: seen.append(("quick", start, end))
    cpu.attach("urgent", lambda: quick.transaction(bytearray(1)))
    cpu.time.at(10_000, cpu.lines["urgent"].request)
    outer = bytearray(b"\x0f" * 10)
    slow.transaction(outer)
    assert seen == [("slow", 0, 80_000), ("quick", 80_000, 88_000)]
    assert outer == b"\xf0" * 10
    assert bus.waits == 1


@pytest.mark.parametrize(
    ("frequency_hz", "bit_ns"), [(100_000, 10_000), (400_000, 2_500), (1_000_000, 1_000)]
)
def test_i2c_register_read_takes_its_clocks(frequency_hz: int, bit_ns: int) -> None:
    """(2 + 1 + n) bytes of 9 clocks, start, repeated start and stop; the instants of write and read."""
    cpu = processor()
    bus = EmulatedI2cBus(cpu, frequency_hz)
    slave = RegisterSlave()
    bus.attach(0x68, slave)
    for n in (1, 6, 15):
        start = cpu.time.now
        bus.transaction(0x68, b"\x0c", n)
        assert cpu.time.now - start == ((2 + 1 + n) * 9 + 3) * bit_ns
        assert slave.written_at[-1] - start == (1 + 2 * 9) * bit_ns
        assert slave.read_at[-1] - start == (1 + 2 * 9 + 1 + 9) * bit_ns
    assert bus.transactions == 3
    assert bus.busy_ns == cpu.time.now


def test_i2c_compass_command_and_answer() -> None:
    """HMC6343 at 100 kHz: command 18 clocks + start and stop = 0.2 ms, answer 63 + 2 = 0.65 ms."""
    cpu = processor()
    bus = EmulatedI2cBus(cpu, 100_000)
    bus.attach(0x19, RegisterSlave())
    bus.transaction(0x19, b"\x50")
    assert cpu.time.now == 200_000
    bus.transaction(0x19, b"", 6)
    assert cpu.time.now == 850_000


def test_i2c_errors_take_their_time_too() -> None:
    cpu = processor()
    bus = EmulatedI2cBus(cpu, 100_000, stretch_limit_ns=1_000_000)
    bus.attach(0x20, RegisterSlave(refuses_from=1))
    stretching = RegisterSlave()
    stretching.stretch_ns = 400_000  # type: ignore[attr-defined]
    bus.attach(0x21, stretching)
    with pytest.raises(BusError, match="address not acknowledged: nobody at 0x50 on 'i2c'"):
        bus.transaction(0x50, b"\x00", 4)
    assert cpu.time.now == (1 + 9 + 1) * 10_000
    with pytest.raises(BusError, match="data not acknowledged: byte 2 of 2 to 0x20 on 'i2c'"):
        bus.transaction(0x20, b"\x00\x01")
    assert cpu.time.now == (11 + 1 + 27 + 1) * 10_000
    bus.transaction(0x21, b"\x00")
    assert cpu.time.now == (40 + 20) * 10_000 + 400_000
    stretching.stretch_ns = 2_000_000  # type: ignore[attr-defined]
    with pytest.raises(BusError, match="timeout: 0x21 on 'i2c' holds the clock"):
        bus.transaction(0x21, b"\x00")
    assert cpu.time.now == (60 + 10) * 10_000 + 1_400_000


def test_i2c_interrupted_transaction_is_not_disturbed() -> None:
    """A handler that uses the bus it has interrupted gets an error, as from a busy controller."""
    cpu = processor("urgent")
    bus = EmulatedI2cBus(cpu, 100_000)
    bus.attach(0x68, RegisterSlave())
    errors: list[str] = []

    def handler() -> None:
        with pytest.raises(BusError) as caught:
            bus.transaction(0x68, b"\x00", 1)
        errors.append(caught.value.detail)

    cpu.attach("urgent", handler)
    cpu.time.at(100_000, cpu.lines["urgent"].request)
    assert bus.transaction(0x68, b"\x10", 2) == b"\x10\x11"
    assert errors == ["'i2c' is busy with a transaction of 'main'"]


@pytest.mark.parametrize(
    ("baud", "byte_us", "sentence_ms"),
    [
        (4800, 2083.33, None),
        (9600, 1041.67, 77.1),
        (19200, 520.83, 38.5),
        (38400, 260.42, None),
        (57600, 173.61, None),
        (115_200, 86.81, 6.4),
    ],
)
def test_uart_byte_takes_ten_bits(baud: int, byte_us: float, sentence_ms: float | None) -> None:
    time = VirtualTime()
    wire = UartWire(time, baud)
    far_end = Collector()
    wire.connect(far_end)
    wire.send(b"$")
    time.run_next()
    assert far_end.chunks[0][0] / 1000 == pytest.approx(byte_us, abs=0.006)
    if sentence_ms is not None:
        start = time.now
        wire.send(bytes(74))
        time.run_next()
        assert (time.now - start) / 1e6 == pytest.approx(sentence_ms, abs=0.06)


@given(
    st.sampled_from([9600, 57_600, 115_200, 230_400, 921_600]),
    st.lists(st.integers(1, 40), min_size=1, max_size=12),
)
def test_uart_pieces_queued_back_to_back_are_not_rounded_twice(baud: int, lengths: list[int]) -> None:
    time = VirtualTime()
    wire = UartWire(time, baud)
    far_end = Collector()
    wire.connect(far_end)
    for length in lengths:
        wire.send(bytes(length))
    while time.next_due < SECOND * 100:
        time.run_next()
    ends = [sum(lengths[: n + 1]) * 10 * SECOND // baud for n in range(len(lengths))]
    assert [at for at, _ in far_end.chunks] == ends
    assert wire.idle_from == ends[-1]


@pytest.mark.parametrize("observed", [False, True])
@pytest.mark.parametrize("at_ns", [150_000, 195_000, 290_000, 480_000, 565_000])
def test_i2c_interrupt_that_outlasts_the_wire_never_turns_time_back(at_ns: int, observed: bool) -> None:
    """Two bytes written (290 µs), two read (570 µs in all at 100 kHz), a handler of 2 ms somewhere within."""
    cpu = processor("urgent")
    bus = EmulatedI2cBus(cpu, 100_000)
    bus.attach(0x19, RegisterSlave())
    bus.observer = (lambda _done: None) if observed else None
    left: list[int] = []

    def handler() -> None:
        cpu.spend(140_000)
        left.append(cpu.time.now)

    cpu.attach("urgent", handler)
    cpu.time.at(at_ns, cpu.lines["urgent"].request)
    bus.transaction(0x19, b"\x01\x02", 2)
    assert left
    assert cpu.time.now == max(580_000, left[0])
    cpu.delay(300_000)
    assert cpu.time.now == max(580_000, left[0]) + 300_000
