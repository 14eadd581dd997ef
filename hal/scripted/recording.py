"""Any backend, with everything that goes over it written down as a transcript.

    recording = Recording(file)
    chip = Bmi160(recording.spi("imu", device), recording.cpu(cpu), config)

The file then is what `Transcript` reads, so that the test body that made it runs again without the
hardware. Written down are SPI, I²C, dual-port memories, what goes out and comes in on UART and CAN, output
pins and delays. Readings of the clock are not: a scripted clock moves by the delays. Nor are interrupts of
pins, timers and captures, which a program that sleeps would wait for.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TextIO

from hal.can import CanController, CanFrame
from hal.cpu import Cpu
from hal.dual_port import DualPortMemory
from hal.errors import BusError, ErrorKind
from hal.i2c import I2cBus
from hal.interrupts import InterruptLine
from hal.pins import OutputPin
from hal.scripted.i2c import FAILURES
from hal.scripted.transcript import hex_words
from hal.spi import SpiDevice
from hal.uart import Uart

WORDS = {kind: word for word, kind in FAILURES.items()}


class Recording:
    """Writes one transcript; hands out recording faces of real peripherals by the names of its steps."""

    def __init__(self, file: TextIO) -> None:
        self._file = file
        self.steps = 0

    def comment(self, text: str) -> None:
        """A line for people."""
        self._file.write(f"# {text}\n")

    def write(self, step: str) -> None:
        """One step or arrival."""
        self._file.write(step + "\n")
        self.steps += 1

    def spi(self, name: str, device: SpiDevice) -> RecordingSpi:
        """A device whose transactions are written down."""
        return RecordingSpi(self, name, device)

    def i2c(self, name: str, bus: I2cBus) -> RecordingI2c:
        """A bus whose transactions are written down."""
        return RecordingI2c(self, name, bus)

    def uart(self, name: str, port: Uart) -> RecordingUart:
        """A port whose traffic is written down."""
        return RecordingUart(self, name, port)

    def can(self, name: str, controller: CanController) -> RecordingCan:
        """A controller whose frames are written down."""
        return RecordingCan(self, name, controller)

    def memory(self, name: str, side: DualPortMemory) -> RecordingDualPort:
        """A side of a dual-port memory whose accesses are written down."""
        return RecordingDualPort(self, name, side)

    def output(self, name: str, pin: OutputPin) -> RecordingOutput:
        """A pin whose levels are written down."""
        return RecordingOutput(self, name, pin)

    def cpu(self, cpu: Cpu) -> RecordingCpu:
        """A processor whose delays are written down."""
        return RecordingCpu(self, cpu)


class RecordingSpi:
    """Implements `hal.spi.SpiDevice`."""

    def __init__(self, recording: Recording, name: str, device: SpiDevice) -> None:
        self._recording = recording
        self._name = name
        self._device = device

    def transaction(self, buffer: bytearray) -> None:
        """Exchange the whole buffer in place."""
        mosi = hex_words(buffer)
        self._device.transaction(buffer)
        self._recording.write(f"spi {self._name} {mosi} -> {hex_words(buffer)}")


class RecordingI2c:
    """Implements `hal.i2c.I2cBus`. Errors that a transcript has no word for are written as time-outs."""

    def __init__(self, recording: Recording, name: str, bus: I2cBus) -> None:
        self._recording = recording
        self._name = name
        self._bus = bus

    def transaction(self, address: int, write: bytes = b"", read_length: int = 0) -> bytes:
        """Run one transaction and return the bytes read."""
        step = f"i2c {self._name} {address:02x}"
        step += f" write {hex_words(write)}" if write else ""
        step += f" read {read_length}" if read_length else ""
        try:
            data = self._bus.transaction(address, write, read_length)
        except BusError as error:
            self._recording.write(f"{step} -> {WORDS.get(error.kind, WORDS[ErrorKind.TIMEOUT])}")
            raise
        self._recording.write(f"{step} -> {hex_words(data)}" if data else step)
        return data


class RecordingUart:
    """Implements `hal.uart.Uart`. Arrivals are written down when the firmware learns of them."""

    def __init__(self, recording: Recording, name: str, port: Uart) -> None:
        self._recording = recording
        self._name = name
        self._port = port
        self._ring = bytearray()
        self._written = 0

    def set_baud(self, baud: int) -> None:
        """Change the bit rate."""
        self._port.set_baud(baud)
        self._recording.write(f"uart {self._name} baud {baud}")

    def write(self, data: bytes) -> int:
        """Queue bytes for transmission and return how many were taken."""
        taken = self._port.write(data)
        if data:
            reply = "" if taken == len(data) else f" -> {taken}"
            self._recording.write(f"uart {self._name} write {hex_words(data)}{reply}")
        return taken

    def tx_free(self) -> int:
        """Room left in the transmit queue."""
        return self._port.tx_free()

    def start_receive(self, ring: bytearray, line: InterruptLine) -> None:
        """Receive into `ring`."""
        self._ring = ring
        self._written = 0
        self._port.start_receive(ring, line)

    def received(self) -> int:
        """Bytes put into the ring since `start_receive`."""
        received = self._port.received()
        size = len(self._ring)
        first = max(self._written, received - size) if size else received
        if first < received:
            data = bytes(self._ring[at % size] for at in range(first, received))
            lost = first - self._written
            # What the ring has lost nobody can read any more; its place is kept, so that counts agree.
            self._recording.write(f"<- uart {self._name} {hex_words(bytes(lost) + data)}")
            self._written = received
        return received

    def take_errors(self) -> int:
        """Errors since the last call."""
        errors = self._port.take_errors()
        if errors:
            self._recording.write(f"<- uart {self._name} errors {errors}")
        return errors


class RecordingCan:
    """Implements `hal.can.CanController`."""

    def __init__(self, recording: Recording, name: str, controller: CanController) -> None:
        self._recording = recording
        self._name = name
        self._controller = controller

    def send(self, frames: Sequence[CanFrame]) -> int:
        """Queue frames in order and return how many were taken."""
        taken = self._controller.send(frames)
        for number, frame in enumerate(frames[: taken + 1]):
            full = " -> full" if number == taken else ""
            self._recording.write(f"can {self._name} send {_frame_words(frame)}{full}")
        return taken

    def receive(self) -> CanFrame | None:
        """The oldest frame received, or None."""
        frame = self._controller.receive()
        if frame is not None:
            self._recording.write(f"<- can {self._name} {_frame_words(frame)}")
        return frame


class RecordingDualPort:
    """Implements `hal.dual_port.DualPortMemory`. Rings are written down when the firmware learns of them."""

    def __init__(self, recording: Recording, name: str, side: DualPortMemory) -> None:
        self.words = side.words
        self.word_bytes = side.word_bytes
        self.interrupt_on_ring: Callable[[InterruptLine], None] = side.interrupt_on_ring
        self._recording = recording
        self._name = name
        self._side = side
        self._rung = 0

    def read(self, address: int, count: int) -> bytes:
        """Read words."""
        data = self._side.read(address, count)
        self._recording.write(f"memory {self._name} read {address} {count} -> {hex_words(data)}")
        return data

    def write(self, address: int, data: bytes) -> None:
        """Write words."""
        self._side.write(address, data)
        self._recording.write(f"memory {self._name} write {address} {hex_words(data)}")

    def ring(self, value: int) -> None:
        """Interrupt the other side."""
        self._side.ring(value)
        self._recording.write(f"memory {self._name} ring {value}")

    def rung(self) -> int:
        """The word in the mailbox."""
        value = self._side.rung()
        if value != self._rung:
            self._rung = value
            self._recording.write(f"<- memory {self._name} ring {value}")
        return value


class RecordingOutput:
    """Implements `hal.pins.OutputPin`."""

    def __init__(self, recording: Recording, name: str, pin: OutputPin) -> None:
        self._recording = recording
        self._name = name
        self._pin = pin

    def set(self, level: bool) -> None:
        """Drive the electrical level."""
        self._pin.set(level)
        self._recording.write(f"pin {self._name} {'high' if level else 'low'}")


class RecordingCpu:
    """Implements `hal.cpu.Cpu`; delays are steps, work is none."""

    def __init__(self, recording: Recording, cpu: Cpu) -> None:
        self._recording = recording
        self.cost: Callable[[str], int] = cpu.cost
        self.spend: Callable[[int], None] = cpu.spend
        self.wait_for_interrupt: Callable[[], None] = cpu.wait_for_interrupt
        self._delay = cpu.delay

    def delay(self, duration_ns: int) -> None:
        """Busy-wait."""
        self._recording.write(f"delay {duration_ns}")
        self._delay(duration_ns)


def _frame_words(frame: CanFrame) -> str:
    identifier = f"{frame.identifier:08x}x" if frame.extended else f"{frame.identifier:03x}"
    return f"{identifier} {hex_words(frame.data)}".rstrip()
