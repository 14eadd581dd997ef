"""What firmware and foreign chips may hand to the engine, be it machine code or interpreted."""

import copy
import pickle
from collections.abc import Iterable
from typing import Any

import numpy as np
import pytest

from hal.emulated.cpu import EmulatedCpu
from hal.emulated.dual_port import EmulatedDualPort
from hal.emulated.pins import EmulatedOutputPin, Net
from hal.emulated.spi import EmulatedSpiBus, SpiSlave, SpiTiming
from hal.emulated.timers import EmulatedPeriodicTimer
from hal.emulated.uart import EmulatedUart, UartPeer, UartWire
from hal.emulated.virtual_time import VirtualTime

MHZ_100 = 100_000_000


@pytest.fixture
def cpu() -> EmulatedCpu:
    return EmulatedCpu(VirtualTime(), "main", MHZ_100)


def test_counts_and_times_may_be_numpys(cpu: EmulatedCpu) -> None:
    cpu.spend(np.int64(100))
    assert cpu.time.now == 1000
    cpu.delay(np.uint32(500))
    assert cpu.time.now == 1500
    assert type(cpu.time.now) is int


def test_a_large_count_of_numpy_does_not_overflow(cpu: EmulatedCpu) -> None:
    cpu.spend(np.int32(2_000_000_000))
    assert cpu.time.now == 20_000_000_000


@pytest.mark.parametrize("value", [1e6, np.float32(5.0), None, "5"])
def test_what_is_no_whole_number_is_told_by_its_name(cpu: EmulatedCpu, value: Any) -> None:
    for door, name in (
        (cpu.spend, "cycles to spend"),
        (cpu.delay, "delay in ns"),
        (lambda time: cpu.time.at(time, lambda: None), "time of an event in ns"),
        (lambda rate: EmulatedPeriodicTimer(cpu).start(rate, None), "timer rate in Hz"),  # type: ignore[arg-type]
        (SpiTiming, "SPI timing frequency_hz"),
    ):
        with pytest.raises(TypeError, match=f"{name} = .*; it must be a whole number, e.g. "):
            door(value)
    assert cpu.time.now == 0


def test_an_event_may_repeat_at_a_time_of_numpys() -> None:
    time = VirtualTime()
    seen = []

    def repeat() -> Any:
        seen.append(time.now)
        return np.int64(time.now + 10) if len(seen) < 3 else None

    time.at(np.int64(5), repeat)
    while len(seen) < 3:
        time.run_next()
    assert seen == [5, 15, 25]


def test_an_event_that_repeats_at_a_fraction_is_told() -> None:
    time = VirtualTime()
    time.at(5, lambda: 1e9)  # type: ignore[arg-type,return-value]
    with pytest.raises(TypeError, match=r"time at which an event repeats in ns = 1000000000\.0"):
        time.run_next()


@pytest.mark.parametrize("high", [1, np.bool_(True), np.float32(2.0) > 1.0, 0x40])
def test_a_pin_takes_whatever_is_true_or_false(cpu: EmulatedCpu, high: Any) -> None:
    net = Net(cpu.time, "net")
    pin = EmulatedOutputPin(cpu, net)
    heard: list[tuple[bool, int]] = []
    net.listen(lambda level, now: heard.append((level, now)))
    pin.set(high)
    assert net.level is True
    net.set(high)
    net.set(type(high)(0))
    assert net.level is False
    assert heard == [(True, 0), (False, 0)]


@pytest.mark.parametrize(
    "form", [bytes, bytearray, memoryview, list, lambda data: np.frombuffer(data, np.uint8)]
)
def test_a_uart_sends_bytes_in_any_form(cpu: EmulatedCpu, form: Any) -> None:
    class Ear(UartPeer):
        heard = b""

        def receive(self, data: bytes, time_ns: int) -> None:
            self.heard += data

    ear = Ear()
    tx = UartWire(cpu.time, 9600, "tx", capacity=100)
    tx.connect(ear)
    uart = EmulatedUart(cpu, tx, UartWire(cpu.time, 9600, "rx"))
    uart.set_baud(np.int64(115_200))
    sent: Iterable[int] = form(b"\x01\xff")
    assert uart.write(sent) == 2
    cpu.delay(1_000_000)
    assert ear.heard == b"\x01\xff"


@pytest.mark.parametrize("form", [bytes, bytearray])
def test_a_chip_may_name_its_interface_and_answer_a_bytearray(cpu: EmulatedCpu, form: Any) -> None:
    class Chip(SpiSlave):
        def transaction(self, mosi: bytes | bytearray, start_ns: int, end_ns: int) -> Any:
            return form(value ^ 0xFF for value in mosi)

    device = EmulatedSpiBus(cpu, SpiTiming(np.int64(1_000_000))).device(Chip(), "chip")  # type: ignore[arg-type]
    buffer = bytearray(b"\x01\x02")
    device.transaction(buffer)
    assert buffer == b"\xfe\xfd"
    assert cpu.time.now == 16_000


def test_a_timing_can_be_copied_and_pickled() -> None:
    timing = SpiTiming(5_250_000, 16, stall_ns=9000)
    assert copy.deepcopy(timing) == pickle.loads(pickle.dumps(timing)) == timing


@pytest.mark.parametrize("form", [bytes, bytearray, memoryview])
def test_words_between_processors_may_come_in_any_form(cpu: EmulatedCpu, form: Any) -> None:
    memory = EmulatedDualPort("memory", 16)
    side, other = memory.side(cpu, 30), memory.side(cpu, 30)
    side.write(np.int64(2), form(b"abcd"))
    assert other.read(np.int64(1), np.int64(2)) == b"\0\0\0\0abcd"
    side.ring(np.uint32(7))
    assert other.rung() == 7
