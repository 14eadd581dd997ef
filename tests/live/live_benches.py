"""Benches of the conformance checks in real time, each on a real link of the system."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import can
from emulated_bus_pirate import EmulatedBusPirate
from pty_port import PtyPort
from rfc2217_server import Rfc2217Server

from hal.can import CanFrame
from hal.conformance.i2c import I2cCase
from hal.endings import ProcessorReset
from hal.errors import ErrorKind
from hal.live.bus_pirate_buses import BusPirateI2c, BusPirateSpi
from hal.live.can import LiveCan
from hal.live.cpu import LiveCpu
from hal.live.interrupt_line import LiveLine
from hal.live.pins import ModemInput, ModemInputLine, ModemOutput, ModemOutputLine
from hal.live.serial_link import SerialLink
from hal.live.storage import LiveLogFile
from hal.live.timers import LiveCapture, LiveTimer
from hal.live.uart import LiveUart
from hal.live.watchdog import LiveWatchdog

MS = 1_000_000
PATIENCE_S = 2.0


def until(reached: Callable[[], bool], patience_s: float = PATIENCE_S) -> None:
    """Wait for something that another thread brings about."""
    deadline = time.monotonic() + patience_s
    while not reached() and time.monotonic() < deadline:
        time.sleep(0.001)


def processor(*lines: str) -> LiveCpu:
    return LiveCpu({name: priority for priority, name in enumerate(lines, 1)})


class LiveInterrupts:
    nests = True
    knows_names = True

    def __init__(self, _folder: Path) -> None:
        self.cpu = self.controller = processor("urgent", "middle", "background")

    def settle(self) -> None:
        self.cpu.spend(1)


class LiveClock:
    tolerance = 0.0

    def __init__(self, _folder: Path) -> None:
        self.cpu = self.clock = processor()

    def expect_delay(self, duration_ns: int) -> None:
        pass


class ModemJumper:
    """loop:// joins RTS with CTS."""

    def __init__(self, _folder: Path) -> None:
        self.cpu = processor("pin", "timer", "capture")
        self.link = SerialLink("loop://", 9600)
        self.output = ModemOutput(self.cpu, self.link, ModemOutputLine.RTS)
        self.input = ModemInput(self.cpu, self.link, ModemInputLine.CTS)

    def line(self, handler: Callable[[], None]) -> LiveLine:
        return self.cpu.attach("pin", handler)

    def expect(self, level: bool) -> None:
        pass

    def settle(self) -> None:
        self.cpu.delay(4 * MS)

    def close(self) -> None:
        self.link.close()


class LiveTimers:
    def __init__(self, folder: Path) -> None:
        self._jumper = ModemJumper(folder)
        self._jumper.output.set(False)
        self._cpu = self._jumper.cpu
        self.timer = LiveTimer(self._cpu)
        self.capture = LiveCapture(self._cpu, self._jumper.input)

    def line(self, name: str, handler: Callable[[], None]) -> LiveLine:
        return self._cpu.attach(name, handler)

    def expect(self, action: str) -> None:
        pass

    def wait(self, duration_ns: int, expiries: int) -> None:
        self._cpu.delay(duration_ns)

    def edge(self) -> int | None:
        for level in (True, False):
            self._jumper.output.set(level)
            self._jumper.settle()
        return None

    def close(self) -> None:
        self._jumper.close()


class LiveStorage:
    cut_power = None

    def __init__(self, folder: Path) -> None:
        self._folder = folder / "card"
        self._folder.mkdir()
        self.log = LiveLogFile(processor(), self._folder / "log.bin")

    def expect(self, action: str) -> None:
        pass

    def remove_card(self) -> None:
        shutil.rmtree(self._folder)

    def contents(self) -> bytes:
        return self.log.path.read_bytes() if self.log.path.exists() else b""

    def close(self) -> None:
        self.log.close()


class LiveWatchdogBench:
    def __init__(self, _folder: Path) -> None:
        self._cpu = processor()
        self.watchdog = LiveWatchdog(self._cpu)
        self._bitten = False

    def wait(self, duration_ns: int) -> None:
        try:
            self._cpu.delay(duration_ns)
        except ProcessorReset:
            self._bitten = True

    def bitten(self) -> bool:
        return self._bitten


class PtySerial:
    """A UART on a pseudo-terminal."""

    def __init__(self, folder: Path) -> None:
        self._cpu = processor("rx")
        self._device = PtyPort(folder / "ttyTEST")
        self._interrupts = 0
        self._open(str(self._device.path))

    def _open(self, url: str) -> None:
        self.port = LiveUart(self._cpu, SerialLink(url, 115_200))

    def line(self, handler: Callable[[], None]) -> LiveLine:
        return self._cpu.attach("rx", handler)

    def expect(self, data: bytes) -> None:
        self._expected = len(self._far_end()) + len(data)

    def feed(self, data: bytes) -> None:
        self._fed = self.port.link.counters.bytes_received + len(data)
        self._device.send(data)

    def settle(self) -> None:
        until(lambda: len(self._far_end()) >= getattr(self, "_expected", 0))
        until(lambda: self.port.link.counters.bytes_received >= getattr(self, "_fed", 0))
        self._cpu.delay(3 * MS)

    def sent(self) -> bytes:
        return bytes(self._far_end())

    def _far_end(self) -> bytes | bytearray:
        return self._device.written

    def close(self) -> None:
        self.port.link.close()
        self._device.unplug()


class TcpSerial(PtySerial):
    """A UART on a TCP connection."""

    def __init__(self, folder: Path) -> None:
        import socket
        from threading import Thread

        self._cpu = processor("rx")
        self._server = socket.create_server(("127.0.0.1", 0))
        self._written = bytearray()
        self._open(f"socket://127.0.0.1:{self._server.getsockname()[1]}")
        self._connection, _ = self._server.accept()
        Thread(target=self._collect, daemon=True).start()

    def _collect(self) -> None:
        try:
            while data := self._connection.recv(4096):
                self._written += data
        except OSError:
            return

    def feed(self, data: bytes) -> None:
        self._fed = self.port.link.counters.bytes_received + len(data)
        self._connection.sendall(data)

    def _far_end(self) -> bytes:
        return bytes(self._written)

    def close(self) -> None:
        self.port.link.close()
        self._connection.close()
        self._server.close()


class Rfc2217Serial(PtySerial):
    """A UART behind a server that speaks RFC 2217, itself on a pseudo-terminal."""

    def _open(self, url: str) -> None:
        self._server = Rfc2217Server(url)
        super()._open(f"rfc2217://127.0.0.1:{self._server.port}")

    def close(self) -> None:
        self.port.link.close()
        self._server.close()
        self._device.unplug()


class LoopSerial(PtySerial):
    """A UART with a jumper: what it sends is what it receives."""

    def __init__(self, folder: Path) -> None:
        self._cpu = processor("rx")
        self._heard = bytearray()
        self._open("loop://")
        arrive = self.port.link.receiver
        assert arrive is not None

        def hear(data: bytes) -> None:
            self._heard += data
            arrive(data)

        self.port.link.receiver = hear

    def feed(self, data: bytes) -> None:
        self._fed = self.port.link.counters.bytes_received + len(data)
        self.port.link.write(data)

    def _far_end(self) -> bytes:
        return bytes(self._heard)

    def close(self) -> None:
        self.port.link.close()


class VirtualCan:
    """Two nodes of python-can's virtual bus."""

    interface = "virtual"
    channel = "navtwin-test"

    def __init__(self, _folder: Path) -> None:
        self.controller = LiveCan(processor(), self.interface, self.channel)
        self._other = can.Bus(interface=self.interface, channel=self.channel)
        self._frames: list[CanFrame] = []
        self._fed = 0

    def expect(self, frames: Sequence[CanFrame]) -> None:
        pass

    def feed(self, frame: CanFrame) -> None:
        self._fed += 1
        self._other.send(
            can.Message(arbitration_id=frame.identifier, data=frame.data, is_extended_id=frame.extended)
        )

    def settle(self) -> None:
        while (message := self._other.recv(0.1)) is not None:
            frame = CanFrame(message.arbitration_id, bytes(message.data), message.is_extended_id)
            self._frames.append(frame)
        until(lambda: self.controller.frames_received >= self._fed)

    def sent(self) -> list[CanFrame]:
        return self._frames

    def close(self) -> None:
        self.controller.close()
        self._other.shutdown()


class MulticastCan(VirtualCan):
    """Two nodes on UDP multicast, through the system's network."""

    interface = "udp_multicast"
    channel = "239.74.163.2"


class Complementing:
    """SPI slave that answers every byte with its complement."""

    def transaction(self, mosi: bytes | bytearray, start_ns: int, end_ns: int) -> bytes:
        return bytes(byte ^ 0xFF for byte in mosi)


class BridgeSpi:
    """SPI through the bridge's protocol on a pseudo-terminal."""

    def __init__(self, folder: Path) -> None:
        cpu = processor()
        self._port = PtyPort(folder / "ttyBRIDGE", EmulatedBusPirate(spi=Complementing()).feed)
        self._empty = PtyPort(folder / "ttyEMPTY", EmulatedBusPirate().feed)
        self.device = BusPirateSpi(cpu, str(self._port.path))
        self.absent = BusPirateSpi(cpu, str(self._empty.path))

    def prepare(self, mosi: bytes) -> bytes:
        return bytes(byte ^ 0xFF for byte in mosi)

    def close(self) -> None:
        self.device.close()
        self.absent.close()
        self._port.unplug()
        self._empty.unplug()


class Memory:
    """I²C memory with a register pointer; refuses bytes from `refuses_from` on."""

    def __init__(self, refuses_from: int = 1000) -> None:
        self.registers = bytearray(range(256))
        self.pointer = 0
        self.refuses_from = refuses_from

    def write(self, data: bytes, time_ns: int) -> int:
        self.pointer = data[0] + len(data) - 1
        self.registers[data[0] : self.pointer] = data[1:]
        return len(data)

    def read(self, length: int, time_ns: int) -> bytes:
        self.pointer += length
        return bytes(self.registers[self.pointer - length : self.pointer])


class BridgeI2c:
    """I²C through the bridge's protocol on a pseudo-terminal."""

    cases: Sequence[I2cCase] = (
        I2cCase(0x68, b"", 0, b""),
        I2cCase(0x68, b"\x10", 0, b""),
        I2cCase(0x68, b"", 3, b"\x10\x11\x12"),
        I2cCase(0x50, b"\x00", 1, ErrorKind.ADDRESS_NACK),
        I2cCase(0x50, b"", 0, ErrorKind.ADDRESS_NACK),
        I2cCase(0x50, b"", 4, ErrorKind.ADDRESS_NACK),
        I2cCase(0x68, b"\x20", 2, b"\x20\x21"),
        I2cCase(0x69, b"\x20\x00\x00", 0, ErrorKind.DATA_NACK),
        I2cCase(0x68, bytes((0x40, *range(40))), 0, b""),
        I2cCase(0x68, b"\x40", 100, bytes(range(40)) + bytes(range(0x40 + 40, 0x40 + 100))),
    )

    def __init__(self, folder: Path) -> None:
        chips = {0x68: Memory(), 0x69: Memory(refuses_from=1)}
        self._port = PtyPort(folder / "ttyBRIDGE", EmulatedBusPirate(i2c=dict(chips)).feed)
        self.bus = BusPirateI2c(processor(), str(self._port.path))

    def close(self) -> None:
        self.bus.close()
        self._port.unplug()
