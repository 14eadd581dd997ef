"""The bridge when things go wrong: told at set-up, endured afterwards."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from threading import Event, Thread
from unittest import mock

import numpy as np
import pytest
from emulated_bus_pirate import EmulatedBusPirate
from hypothesis import given, settings
from hypothesis import strategies as some
from live_benches import Complementing, Memory
from pty_port import PtyPort

from hal.errors import BusError, ErrorKind
from hal.live.bridge_session import BridgeCounters
from hal.live.bus_pirate import BusPirateError
from hal.live.bus_pirate_buses import BusPirateAux, BusPirateI2c, BusPirateSpi
from hal.live.cpu import LiveCpu
from hal.live.port import PortError


def exchanged(device: BusPirateSpi, mosi: bytes) -> bytes:
    buffer = bytearray(mosi)
    device.transaction(buffer)
    return bytes(buffer)


def comes_back(device: BusPirateSpi, patience_s: float = 8.0) -> bool:
    deadline = time.monotonic() + patience_s
    while time.monotonic() < deadline:
        if exchanged(device, b"\x01\x02") == b"\xfe\xfd":
            return True
        time.sleep(0.02)
    return False


# -- set-up ----------------------------------------------------------------------------------------


def refusal(tmp_path: Path, feed: Callable[[bytes], bytes | None]) -> str:
    with PtyPort(tmp_path / "ttyBRIDGE", feed) as port, pytest.raises(BusPirateError) as caught:
        BusPirateSpi(LiveCpu(), str(port.path))
    message = str(caught.value)
    assert "\n" not in message
    return message.replace(str(tmp_path), "")


def test_a_silent_device_is_no_bus_pirate(tmp_path: Path) -> None:
    message = refusal(tmp_path, lambda _data: None)
    assert message.startswith("/ttyBRIDGE: nothing answers; is it a Bus Pirate v3 or v4, at 115200 baud?")


def test_a_device_that_says_something_else_is_quoted(tmp_path: Path) -> None:
    message = refusal(tmp_path, lambda _data: b"$GNRMC,,V*37\r\n")
    assert "'$GNRMC,,V*37..$GNRMC,,V*" in message
    assert "instead of BBIO1" in message


def test_a_device_that_never_stops_talking_is_no_bus_pirate(tmp_path: Path) -> None:
    stop = Event()
    with PtyPort(tmp_path / "ttyTALK") as port:

        def talk() -> None:
            while not stop.wait(0.003):
                port.send(b"talk")

        talker = Thread(target=talk, daemon=True)
        talker.start()
        begin = time.monotonic()
        with pytest.raises(BusPirateError, match="instead of BBIO1"):
            BusPirateSpi(LiveCpu(), str(port.path))
        assert time.monotonic() - begin < 2.0
        stop.set()
        talker.join()


def test_an_echo_is_no_bus_pirate(tmp_path: Path) -> None:
    assert "instead of BBIO1" in refusal(tmp_path, lambda data: data)


def test_a_firmware_without_the_mode_is_told(tmp_path: Path) -> None:
    bridge = EmulatedBusPirate(modes="SPI")
    with PtyPort(tmp_path / "ttyBRIDGE", bridge.feed) as port, pytest.raises(BusPirateError) as caught:
        BusPirateI2c(LiveCpu(), str(port.path))
    assert "answers 00 ('.') when asked for its mode I2C1; its firmware lacks that mode" in str(caught.value)


def test_late_answers_to_the_zeros_are_not_taken_for_the_mode_s(tmp_path: Path) -> None:
    bridge = EmulatedBusPirate(spi=Complementing())

    def feed(data: bytes) -> bytes:
        return (b"BBIO1" * 2 if data == b"\x01" else b"") + bridge.feed(data)

    with PtyPort(tmp_path / "ttyBRIDGE", feed) as port:
        device = BusPirateSpi(LiveCpu(), str(port.path))
        assert exchanged(device, b"\x0f") == b"\xf0"
        device.close()


def test_a_setting_that_is_refused_is_told(tmp_path: Path) -> None:
    bridge = EmulatedBusPirate()

    def feed(data: bytes) -> bytes:
        return bridge.feed(data) if data != b"\x63" else b"\x00"

    assert "answers 00 ('.'), not 01, to the setting 0x63" in refusal(tmp_path, feed)


def test_a_port_that_is_missing_is_told() -> None:
    with pytest.raises(PortError, match="there is no such port"):
        BusPirateSpi(LiveCpu(), "/dev/ttyUSB97")


def test_the_port_is_free_after_a_failed_set_up(tmp_path: Path) -> None:
    bridge = EmulatedBusPirate(spi=Complementing())
    with PtyPort(tmp_path / "ttyBRIDGE", lambda _data: None) as port:
        with pytest.raises(BusPirateError):
            BusPirateSpi(LiveCpu(), str(port.path))
        port.receiver = bridge.feed
        device = BusPirateSpi(LiveCpu(), str(port.path))
        assert exchanged(device, b"\x0f") == b"\xf0"
        device.close()


@pytest.mark.parametrize("speed", [30_000, 123, 0])
def test_speeds_that_the_bridge_cannot_keep_up_with_are_refused(speed: int) -> None:
    with pytest.raises(ValueError, match="possible: 125000, 250000"):
        BusPirateSpi(LiveCpu(), "/dev/ttyUSB97", speed_hz=speed)


@pytest.mark.parametrize(
    "before",
    [
        b"\x00" * 20 + b"\x01",  # in SPI mode
        b"\x00" * 20 + b"\x02",  # in I²C mode
        b"\x00" * 20 + b"\x01\x02\x1f\x55",  # in the middle of an exchange of 16 bytes
        b"m\r4\r",  # typing at the terminal
        b"\x00" * 7,
    ],
)
def test_the_mode_is_entered_from_wherever_it_was_left(tmp_path: Path, before: bytes) -> None:
    bridge = EmulatedBusPirate(spi=Complementing())
    bridge.feed(before)
    with PtyPort(tmp_path / "ttyBRIDGE", bridge.feed) as port:
        device = BusPirateSpi(LiveCpu(), str(port.path))
        assert exchanged(device, bytes(range(40))) == bytes(255 - n for n in range(40))
        device.close()
        assert not bridge.power


# -- in flight -------------------------------------------------------------------------------------


class Faulty:
    """A bridge whose answers a fault may change."""

    def __init__(self, bridge: EmulatedBusPirate) -> None:
        self.bridge = bridge
        self.fault: Callable[[bytes], bytes] | None = None
        self.fired = 0

    def feed(self, data: bytes) -> bytes:
        answer = self.bridge.feed(data)
        if self.fault is not None and len(data) > 1:
            self.fired += 1
            answer = self.fault(answer)
        return answer


@pytest.mark.parametrize(
    "fault",
    [
        pytest.param(lambda answer: answer[: len(answer) // 2], id="half an answer"),
        pytest.param(lambda answer: b"", id="no answer"),
        pytest.param(lambda answer: b"\x00" + answer[1:], id="a confirmation that is none"),
        pytest.param(lambda answer: answer[1:] + b"\x55", id="a byte lost and one too many"),
    ],
)
def test_an_answer_that_makes_no_sense_reads_as_a_floating_line(
    tmp_path: Path, fault: Callable[[bytes], bytes]
) -> None:
    faulty = Faulty(EmulatedBusPirate(spi=Complementing()))
    with PtyPort(tmp_path / "ttyBRIDGE", faulty.feed) as port:
        device = BusPirateSpi(LiveCpu(), str(port.path))
        faulty.fault = fault
        assert exchanged(device, b"\x01\x02\x03") == b"\xff\xff\xff"
        assert not device.session.works
        assert faulty.fired == 1
        faulty.fault = None
        assert comes_back(device)
        assert device.session.counters.recoveries == 1
        assert device.session.counters.failures >= 1
        device.close()


def test_a_bridge_that_resets_is_set_up_again(tmp_path: Path) -> None:
    bridge = EmulatedBusPirate(spi=Complementing())
    with PtyPort(tmp_path / "ttyBRIDGE", bridge.feed) as port:
        device = BusPirateSpi(LiveCpu(), str(port.path), speed_hz=4_000_000, mode=3)
        port.send(bridge.reset())
        assert exchanged(device, b"\x01\x02") == b"\xff\xff"
        assert comes_back(device)
        assert (bridge.speed_hz, bridge.spi_config, bridge.power) == (4_000_000, 0b1100, True)
        device.close()


def test_a_bridge_that_is_unplugged_comes_back(tmp_path: Path) -> None:
    bridge = EmulatedBusPirate(spi=Complementing())
    with PtyPort(tmp_path / "ttyBRIDGE", bridge.feed) as port:
        device = BusPirateSpi(LiveCpu(), str(port.path))
        port.unplug()
        begin = time.monotonic()
        for _ in range(20):
            assert exchanged(device, b"\x01\x02") == b"\xff\xff"
            time.sleep(0.01)
        assert time.monotonic() - begin < 1.0  # a port that is not there costs no time
        bridge.reset()
        port.plug_in()
        assert comes_back(device)
        device.close()


def test_i2c_tells_that_the_bridge_is_away(tmp_path: Path) -> None:
    bridge = EmulatedBusPirate(i2c={0x68: Memory()})
    with PtyPort(tmp_path / "ttyBRIDGE", bridge.feed) as port:
        bus = BusPirateI2c(LiveCpu(), str(port.path))
        assert bus.transaction(0x68, b"\x10", 2) == b"\x10\x11"
        port.unplug()
        for _ in range(3):
            with pytest.raises(BusError) as caught:
                bus.transaction(0x68, b"\x10", 2)
            assert caught.value.kind is ErrorKind.TIMEOUT
        bus.close()


def test_closing_twice_and_using_a_closed_bridge_is_harmless(tmp_path: Path) -> None:
    bridge = EmulatedBusPirate(spi=Complementing())
    with PtyPort(tmp_path / "ttyBRIDGE", bridge.feed) as port:
        device = BusPirateSpi(LiveCpu(), str(port.path))
        device.close()
        device.close()
        assert exchanged(device, b"\x01") == b"\xff"


def test_aux_is_driven_and_survives_a_reset(tmp_path: Path) -> None:
    bridge = EmulatedBusPirate(spi=Complementing())
    with PtyPort(tmp_path / "ttyBRIDGE", bridge.feed) as port:
        cpu = LiveCpu()
        device = BusPirateSpi(cpu, str(port.path))
        aux = BusPirateAux(cpu, device.session)
        for level in (True, False, True):
            aux.set(level)
            assert (bridge.aux, bridge.power, bridge.cs) == (level, True, True)
        port.send(bridge.reset())
        assert not bridge.aux
        assert comes_back(device)
        assert bridge.aux
        device.close()


def test_random_answers_never_raise_in_flight(tmp_path: Path) -> None:
    """Whatever comes back, SPI gives as many bytes as were sent, and the bridge is usable afterwards."""
    random = np.random.Generator(np.random.PCG64(11))
    faulty = Faulty(EmulatedBusPirate(spi=Complementing()))
    with PtyPort(tmp_path / "ttyBRIDGE", faulty.feed) as port:
        device = BusPirateSpi(LiveCpu(), str(port.path))
        for _ in range(6):
            garbage = random.bytes(int(random.integers(0, 40)))
            faulty.fault = lambda _answer, garbage=garbage: garbage  # type: ignore[misc]
            assert len(exchanged(device, b"\x01\x02\x03")) == 3
            faulty.fault = None
            assert comes_back(device)
        device.close()
    assert faulty.fired >= 6


BYTE = some.integers(0, 255)
MOSTLY_ONE = some.one_of(some.just(1), some.just(1), some.just(1), BYTE)
BIT = some.one_of(some.sampled_from((0, 1)), some.sampled_from((0, 1)), BYTE)


@settings(deadline=None, max_examples=200)
@given(replies=some.builds(bytes, some.tuples(*[MOSTLY_ONE, MOSTLY_ONE, BIT, BYTE, MOSTLY_ONE, MOSTLY_ONE])))
def test_i2c_makes_of_any_reply_bytes_or_a_bus_error(replies: bytes) -> None:
    """S addr+R, one byte, P is 02 10 d1 04 07 03: the documents' meaning of its six replies."""
    session = AnsweringSession(bytes.fromhex("02 10 d1 04 07 03"), replies)
    with mock.patch("hal.live.bus_pirate_buses.BridgeSession", return_value=session):
        bus = BusPirateI2c(LiveCpu(), "test")
    outcome: bytes | ErrorKind
    try:
        outcome = bus.transaction(0x68, b"", 1)
    except BusError as error:
        outcome = error.kind
    if any(replies[at] != 1 for at in (0, 1, 4, 5)) or replies[2] > 1:
        assert outcome is ErrorKind.OTHER
        assert replies.hex(" ") in session.counters.last_problem
    else:
        assert outcome == (ErrorKind.ADDRESS_NACK if replies[2] else replies[3:4])


class AnsweringSession:
    url = "test"

    def __init__(self, request: bytes, replies: bytes) -> None:
        self._request = request
        self._replies = replies
        self.counters = BridgeCounters()

    def exchange(self, request: bytes, _bus_s: float) -> bytes:
        assert request == self._request
        return self._replies

    def out_of_step(self, problem: str) -> None:
        self.counters.last_problem = problem
