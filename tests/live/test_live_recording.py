"""What is recorded from a backend replays on the scripted one: the same calls, the same answers."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest
from live_benches import BridgeI2c, PtySerial, VirtualCan

from hal.can import CanFrame
from hal.conformance import i2c
from hal.scripted import ScriptedCan, ScriptedCpu, ScriptedI2c, ScriptedOutput, ScriptedUart, Transcript
from hal.scripted.recording import Recording


def test_i2c_replays_with_its_errors(tmp_path: Path) -> None:
    """The conformance cases, recorded from the bridge, hold on the record too."""
    text = io.StringIO()
    bench = BridgeI2c(tmp_path)
    real, bench.bus = bench.bus, Recording(text).i2c("bus", bench.bus)  # type: ignore[assignment]
    i2c.behaves_as_described(bench)
    bench.bus = real
    bench.close()

    class Replay:
        cases = bench.cases
        transcript = Transcript(text.getvalue())
        bus = ScriptedI2c(transcript, "bus")

    i2c.behaves_as_described(Replay)  # type: ignore[arg-type]
    Replay.transcript.finish()


def conversation(port: Any, attach: Callable[..., Any], feed: Callable[[bytes], None]) -> list[object]:
    """A driver that sets a rate, asks, and reads what comes; returns all that it has seen."""
    ring = bytearray(8)
    seen: list[object] = []
    port.start_receive(ring, attach("rx", lambda: None))
    port.set_baud(9600)
    for question, answer in ((b"who", b"me"), (b"\x00\xff", b"0123456789"), (b"bye", b"")):
        seen.append(port.write(question))
        feed(answer)
        seen.append((port.received(), bytes(ring), port.take_errors()))
    return seen


def test_uart_replays_what_came_in_when_it_was_looked_for(tmp_path: Path) -> None:
    text = io.StringIO()
    bench = PtySerial(tmp_path)
    recording = Recording(text)

    def feed(answer: bytes) -> None:
        bench.feed(answer)
        bench.settle()

    seen = conversation(recording.uart("gnss", bench.port), bench._cpu.attach, feed)
    bench.close()
    assert seen[1] == (2, b"me" + bytes(6), 0)
    with Transcript(text.getvalue()) as transcript:
        cpu = ScriptedCpu(transcript)
        replayed = conversation(ScriptedUart(transcript, "gnss"), cpu.attach, lambda _answer: None)
    # Of ten bytes in a ring of eight, the record knows the last eight; those before were lost to everybody.
    assert replayed == seen


FRAMES = (CanFrame(0x123, b"\x01\x02"), CanFrame(0x1ABCDEF0, b"", extended=True))


def test_can_replays_frames_of_both_directions(tmp_path: Path) -> None:
    text = io.StringIO()
    bench = VirtualCan(tmp_path)
    controller = Recording(text).can("can1", bench.controller)
    assert controller.send(FRAMES) == 2
    for frame in FRAMES:
        bench.feed(frame)
    bench.settle()
    assert [controller.receive() for _ in range(3)] == [*FRAMES, None]
    bench.close()
    with Transcript(text.getvalue()) as transcript:
        scripted = ScriptedCan(transcript, "can1")
        assert scripted.send(FRAMES) == 2
        assert [scripted.receive() for _ in range(3)] == [*FRAMES, None]


class FullAfterOne:
    def send(self, frames: Sequence[CanFrame]) -> int:
        return min(1, len(frames))

    def receive(self) -> None:
        return None


def test_a_full_can_queue_is_full_in_the_replay_too() -> None:
    text = io.StringIO()
    assert Recording(text).can("can1", FullAfterOne()).send(FRAMES) == 1
    with Transcript(text.getvalue()) as transcript:
        assert ScriptedCan(transcript, "can1").send(FRAMES) == 1


class Pin:
    def __init__(self) -> None:
        self.levels: list[bool] = []

    def set(self, level: bool) -> None:
        self.levels.append(level)


def test_outputs_and_delays_are_steps_in_their_order() -> None:
    text = io.StringIO()
    recording = Recording(text)
    pin, cpu = Pin(), ScriptedCpu(Transcript("delay 1000\ndelay 20"))

    def body(output: Any, processor: Any) -> None:
        output.set(True)
        processor.delay(1000)
        output.set(False)
        processor.delay(20)

    recording.comment("two pulses")
    body(recording.output("led", pin), recording.cpu(cpu))
    assert pin.levels == [True, False]
    assert text.getvalue() == "# two pulses\npin led high\ndelay 1000\npin led low\ndelay 20\n"
    with Transcript(text.getvalue()) as transcript:
        body(ScriptedOutput(transcript, "led"), ScriptedCpu(transcript))


def test_a_driver_that_changed_is_found_by_the_record() -> None:
    text = io.StringIO()
    Recording(text).output("led", Pin()).set(True)
    with pytest.raises(AssertionError, match="expected: pin led high"), Transcript(text.getvalue()) as script:
        ScriptedOutput(script, "led").set(False)
