"""Transcripts: the first difference shows both sides."""

import pytest

from hal.can import CanFrame
from hal.scripted import (
    ScriptedCan,
    ScriptedCpu,
    ScriptedI2c,
    ScriptedInput,
    ScriptedLog,
    ScriptedSpi,
    ScriptedTimer,
    ScriptedUart,
    ScriptedWatchdog,
    Transcript,
)

START_UP = """
# identify, then wait for the sensor to start
spi imu 80 .. -> 00 d1          # CHIP_ID
spi imu 7e 15 -> 00 00          # gyroscope on
delay 80000000
spi imu 83 .. -> 00 14          # PMU_STATUS
"""


def identify(spi: ScriptedSpi, cpu: ScriptedCpu, command: int = 0x15) -> int:
    buffer = bytearray((0x80, 0x99))
    spi.transaction(buffer)
    spi.transaction(bytearray((0x7E, command)))
    cpu.delay(80_000_000)
    return buffer[1]


def test_driver_that_does_what_is_written_passes() -> None:
    with Transcript(START_UP) as transcript:
        spi, cpu = ScriptedSpi(transcript, "imu"), ScriptedCpu(transcript)
        assert identify(spi, cpu) == 0xD1
        assert cpu.now_ns() >= 80_000_000
        status = bytearray((0x83, 0))
        spi.transaction(status)
        assert status[1] == 0x14


def test_first_difference_shows_both_sides_and_the_place() -> None:
    transcript = Transcript(START_UP)
    with pytest.raises(AssertionError) as caught:
        identify(ScriptedSpi(transcript, "imu"), ScriptedCpu(transcript), command=0x11)
    assert str(caught.value) == (
        "step 2 of 4 (line 4, gyroscope on): the driver differs in word 4 (15 expected, 11 got)\n"
        "  expected: spi imu 7e 15\n"
        "  got:      spi imu 7e 11\n"
        "  before:   spi imu 80 .. -> 00 d1"
    )


def test_longer_and_shorter_actions_differ() -> None:
    transcript = Transcript("spi imu 80 00 -> 00 d1")
    with pytest.raises(AssertionError, match=r"differs in length \(4 words expected, 5 got\)"):
        ScriptedSpi(transcript, "imu").transaction(bytearray((0x80, 0, 0)))


def test_unfinished_transcript_is_an_error() -> None:
    transcript = Transcript(START_UP)
    with pytest.raises(AssertionError) as caught, transcript:
        identify(ScriptedSpi(transcript, "imu"), ScriptedCpu(transcript))
    assert str(caught.value) == (
        "transcript not finished, next is step 4 of 4 (line 6, PMU_STATUS)\n"
        "  expected: spi imu 83 .. -> 00 14\n"
        "  got:      the end"
    )


def test_error_of_the_driver_is_not_covered_up_by_the_unfinished_transcript() -> None:
    with pytest.raises(ZeroDivisionError), Transcript(START_UP):
        _ = 1 // 0


def test_action_after_the_end_is_an_error() -> None:
    transcript = Transcript("watchdog kick")
    watchdog = ScriptedWatchdog(transcript)
    watchdog.kick()
    with pytest.raises(AssertionError, match="transcript of 1 steps is over\n  expected: the end"):
        watchdog.kick()


def test_interfaces_keep_one_order() -> None:
    transcript = Transcript("pin enable high\nuart gnss baud 9600")
    with pytest.raises(AssertionError, match="expected: pin enable high\n  got:      uart gnss baud 9600"):
        ScriptedUart(transcript, "gnss").set_baud(9600)


def test_what_comes_in_wakes_the_driver() -> None:
    with Transcript(
        """
        timer tick start 100
        <- timer tick
        <- timer tick
        log sdcard append 01 02 -> failed
        <- uart gnss 24 47
        <- uart gnss errors 2
        can can1 send 123 01
        can can1 send 00000005x -> full
        uart gnss write 41 42 43 -> 2
        <- time 5000000
        """
    ) as transcript:
        cpu = ScriptedCpu(transcript)
        uart, can = ScriptedUart(transcript, "gnss"), ScriptedCan(transcript, "can1")
        ticks: list[str] = []
        ring = bytearray(4)
        uart.start_receive(ring, cpu.attach("rx", lambda: ticks.append("rx")))
        ScriptedTimer(transcript, "tick").start(100, cpu.attach("tick", lambda: ticks.append("tick")))
        cpu.wait_for_interrupt()
        assert ticks == ["tick"], "two requests before the handler ran are one"
        assert ScriptedLog(transcript, "sdcard").append(b"\x01\x02") is False
        assert uart.received() == 2
        assert ring[:2] == b"$G"
        assert uart.take_errors() == 2
        frames = (CanFrame(0x123, b"\x01"), CanFrame(5, b"", True), CanFrame(6, b""))
        assert can.send(frames) == 1
        assert uart.write(b"ABC") == 2
        before = cpu.now_ns()
        assert before > 5_000_000


def test_sleep_without_anything_to_come_is_an_error() -> None:
    cpu = ScriptedCpu(Transcript("delay 5"))
    with pytest.raises(AssertionError, match="the driver sleeps at step 1, where nothing comes in"):
        cpu.wait_for_interrupt()


def test_bytes_for_a_port_that_does_not_listen_are_an_error() -> None:
    transcript = Transcript("<- uart gnss 24")
    uart = ScriptedUart(transcript, "gnss")
    with pytest.raises(AssertionError, match="the driver has not set up uart 'gnss' for it"):
        uart.received()


def test_bus_errors_can_be_written() -> None:
    bus = ScriptedI2c(Transcript("i2c bus 1e read 2 -> address-nack"), "bus")
    with pytest.raises(Exception, match="address not acknowledged: scripted, address 0x1E on 'bus'"):
        bus.transaction(0x1E, b"", 2)


def test_input_starts_low() -> None:
    transcript = Transcript("<- pin ready low\n<- pin ready high")
    assert ScriptedInput(transcript, "ready").read() is True


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("spy imu 80 -> 00", r"transcript line 1: 'spy imu 80 -> 00' does not start with one of spi, i2c"),
        ("\n<- sensor 1", "transcript line 2: '<- sensor 1' does not start with one of uart, can"),
        ("spi", "transcript line 1: 'spi' is incomplete"),
        ("-> 00", "transcript line 1: '-> 00' has a reply but no action"),
        ("<- line x -> 00", "has a reply to an arrival"),
    ],
)
def test_malformed_lines_are_refused_at_once(text: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Transcript(text)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("spi imu 80 00 -> 00", "the transcript answers 1 bytes to 2 on spi 'imu'"),
        ("spi imu 80 00 -> 00 xy", "'xy' in a transcript is no byte; write two hex digits"),
    ],
)
def test_unusable_replies_are_told(line: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ScriptedSpi(Transcript(line), "imu").transaction(bytearray((0x80, 0)))
