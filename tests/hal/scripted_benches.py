"""Benches of the conformance checks on a transcript, written as the check goes along."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from hal.can import CanFrame
from hal.conformance.i2c import I2cCase
from hal.errors import ErrorKind
from hal.scripted import (
    ScriptedCan,
    ScriptedCapture,
    ScriptedCpu,
    ScriptedI2c,
    ScriptedInput,
    ScriptedLine,
    ScriptedLog,
    ScriptedOutput,
    ScriptedSpi,
    ScriptedTimer,
    ScriptedUart,
    Transcript,
)


class GrowingTranscript(Transcript):
    """A transcript to which a bench adds lines before they are needed."""

    def __init__(self) -> None:
        super().__init__("")

    def add(self, line: str) -> None:
        self.steps.extend(Transcript(line).steps)


class ScriptedSpiBench:
    def __init__(self) -> None:
        self._script = GrowingTranscript()
        self._script.add("spi gone .. .. .. -> ff ff ff")
        self._script.position = 1
        self.device = ScriptedSpi(self._script, "imu")
        self.absent = None

    def prepare(self, mosi: bytes) -> bytes:
        reply = bytes(reversed(mosi))
        self._script.add(f"spi imu {mosi.hex(' ')} -> {reply.hex(' ')}")
        return reply


class ScriptedI2cBench:
    cases: Sequence[I2cCase] = (
        I2cCase(0x68, b"", 0, b""),
        I2cCase(0x68, b"\x10\x01", 0, b""),
        I2cCase(0x68, b"", 2, b"\xab\xcd"),
        I2cCase(0x1E, b"\x20", 2, ErrorKind.ADDRESS_NACK),
        I2cCase(0x68, b"\x20", 2, b"\x01\x02"),
        I2cCase(0x68, b"\x20", 0, ErrorKind.DATA_NACK),
        I2cCase(0x68, b"", 1, ErrorKind.TIMEOUT),
    )

    def __init__(self) -> None:
        script = Transcript(
            """
            i2c bus 68
            i2c bus 68 write 10 01
            i2c bus 68 read 2 -> ab cd
            i2c bus 1e write 20 read 2 -> address-nack
            i2c bus 68 write 20 read 2 -> 01 02
            i2c bus 68 write 20 -> data-nack
            i2c bus 68 read 1 -> timeout
            """
        )
        self.bus = ScriptedI2c(script, "bus")


class ScriptedSerial:
    def __init__(self) -> None:
        self._script = GrowingTranscript()
        self._cpu = ScriptedCpu(self._script)
        self._sent = b""
        self.port = ScriptedUart(self._script, "gnss")

    def line(self, handler: Callable[[], None]) -> ScriptedLine:
        return self._cpu.attach("rx", handler)

    def expect(self, data: bytes) -> None:
        self._script.add(f"uart gnss write {data.hex(' ')}")
        self._sent += data

    def feed(self, data: bytes) -> None:
        self._script.add(f"<- uart gnss {data.hex(' ')}")

    def settle(self) -> None:
        self._cpu.spend(1)

    def sent(self) -> bytes:
        self._script.finish()
        return self._sent


class ScriptedCanBench:
    def __init__(self) -> None:
        self._script = GrowingTranscript()
        self._sent: list[CanFrame] = []
        self.controller = ScriptedCan(self._script, "can1")

    @staticmethod
    def _words(frame: CanFrame) -> str:
        identifier = f"{frame.identifier:08x}x" if frame.extended else f"{frame.identifier:03x}"
        return f"{identifier} {frame.data.hex(' ')}"

    def expect(self, frames: Sequence[CanFrame]) -> None:
        for frame in frames:
            self._script.add(f"can can1 send {self._words(frame)}")
            self._sent.append(frame)

    def feed(self, frame: CanFrame) -> None:
        self._script.add(f"<- can can1 {self._words(frame)}")

    def settle(self) -> None:
        self._script.play()

    def sent(self) -> list[CanFrame]:
        self._script.finish()
        return self._sent


class ScriptedPins:
    def __init__(self) -> None:
        self._script = GrowingTranscript()
        self._cpu = ScriptedCpu(self._script)
        self.output = ScriptedOutput(self._script, "out")
        self.input = ScriptedInput(self._script, "in")

    def line(self, handler: Callable[[], None]) -> ScriptedLine:
        return self._cpu.attach("pin", handler)

    def expect(self, level: bool) -> None:
        word = "high" if level else "low"
        self._script.add(f"pin out {word}")
        self._script.add(f"<- pin in {word}")

    def settle(self) -> None:
        self._cpu.spend(1)


class ScriptedInterrupts:
    nests = False
    knows_names = False

    def __init__(self) -> None:
        self.cpu = self.controller = ScriptedCpu(Transcript(""))

    def settle(self) -> None:
        self.cpu.spend(1)


class ScriptedClock:
    tolerance = 0.0

    def __init__(self) -> None:
        self._script = GrowingTranscript()
        self.cpu = self.clock = ScriptedCpu(self._script)

    def expect_delay(self, duration_ns: int) -> None:
        self._script.add(f"delay {duration_ns}")


class ScriptedTimers:
    def __init__(self) -> None:
        self._script = GrowingTranscript()
        self._cpu = ScriptedCpu(self._script)
        self._clock = 0
        self.timer = ScriptedTimer(self._script, "tick")
        self.capture = ScriptedCapture(self._script, "pps")

    def line(self, name: str, handler: Callable[[], None]) -> ScriptedLine:
        return self._cpu.attach(name, handler)

    def expect(self, action: str) -> None:
        self._script.add(action)

    def wait(self, duration_ns: int, expiries: int) -> None:
        for _ in range(expiries):
            self._script.add("<- timer tick")
            self._cpu.wait_for_interrupt()

    def edge(self) -> int | None:
        self._clock += 1_000_000
        self._script.add(f"<- capture pps {self._clock}")
        self._cpu.spend(1)
        return self._clock


class ScriptedStorage:
    cut_power = None
    remove_card = None

    def __init__(self) -> None:
        self._script = GrowingTranscript()
        self._safe = b""
        self.log = ScriptedLog(self._script, "sdcard")

    def expect(self, action: str) -> None:
        self._script.add(action)
        self._safe += bytes.fromhex(action.partition(" append ")[2])

    def contents(self) -> bytes:
        self._script.finish()
        return self._safe
