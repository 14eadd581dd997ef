"""Benches of the conformance checks on virtual time."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from hal.can import CanFrame
from hal.conformance.i2c import I2cCase
from hal.emulated.can import CanNode, EmulatedCanBus, EmulatedCanController
from hal.emulated.cpu import EmulatedCpu
from hal.emulated.i2c import EmulatedI2cBus
from hal.emulated.interrupt_line import EmulatedLine, LineSpec
from hal.emulated.pins import EmulatedInputPin, EmulatedOutputPin, Net
from hal.emulated.spi import EmulatedSpiBus, SpiTiming
from hal.emulated.storage import EmulatedLogFile
from hal.emulated.timers import EmulatedCaptureTimer, EmulatedPeriodicTimer
from hal.emulated.uart import EmulatedUart, UartWire
from hal.emulated.virtual_time import VirtualTime
from hal.emulated.watchdog import EmulatedWatchdog
from hal.endings import ProcessorReset
from hal.errors import ErrorKind

MS = 1_000_000


def processor(*lines: str, crystal_error_ppb: int = 0) -> EmulatedCpu:
    """A 168 MHz processor with lines in this order of priority."""
    specs = [LineSpec(name, priority) for priority, name in enumerate(lines, 1)]
    return EmulatedCpu(VirtualTime(), "mcu", 168_000_000, specs, crystal_error_ppb=crystal_error_ppb)


class Complementing:
    """SPI slave that answers every byte with its complement."""

    def transaction(self, mosi: bytes | bytearray, start_ns: int, end_ns: int) -> bytes:
        return bytes(byte ^ 0xFF for byte in mosi)


class Floating:
    """Nothing behind the chip select."""

    def transaction(self, mosi: bytes | bytearray, start_ns: int, end_ns: int) -> bytes:
        return b"\xff" * len(mosi)


class EmulatedSpi:
    def __init__(self) -> None:
        bus = EmulatedSpiBus(processor(), SpiTiming(5_250_000))
        self.device = bus.device(Complementing())
        self.absent = bus.device(Floating())

    def prepare(self, mosi: bytes) -> bytes:
        return bytes(byte ^ 0xFF for byte in mosi)


class RegisterSlave:
    """I²C memory with a register pointer; refuses bytes from `refuses_from` on."""

    def __init__(self, refuses_from: int = 1000) -> None:
        self.registers = bytearray(range(256))
        self.pointer = 0
        self.refuses_from = refuses_from
        self.written_at: list[int] = []
        self.read_at: list[int] = []

    def write(self, data: bytes, time_ns: int) -> int:
        self.written_at.append(time_ns)
        self.pointer = data[0]
        for offset, byte in enumerate(data[1:]):
            self.registers[self.pointer + offset] = byte
        return min(len(data), self.refuses_from)

    def read(self, length: int, time_ns: int) -> bytes:
        self.read_at.append(time_ns)
        return bytes(self.registers[self.pointer : self.pointer + length])


class EmulatedI2c:
    cases: Sequence[I2cCase] = (
        I2cCase(0x68, b"", 0, b""),
        I2cCase(0x68, b"\x10", 0, b""),
        I2cCase(0x68, b"", 3, b"\x10\x11\x12"),
        I2cCase(0x50, b"\x00", 1, ErrorKind.ADDRESS_NACK),
        I2cCase(0x50, b"", 0, ErrorKind.ADDRESS_NACK),
        I2cCase(0x68, b"\x20", 2, b"\x20\x21"),
        I2cCase(0x69, b"\x20\x00\x00", 0, ErrorKind.DATA_NACK),
        I2cCase(0x6A, b"\x20", 1, ErrorKind.TIMEOUT),
        I2cCase(0x68, b"\x20", 2, b"\x20\x21"),
    )

    def __init__(self) -> None:
        self.bus = EmulatedI2cBus(processor(), 400_000)
        self.bus.attach(0x68, RegisterSlave())
        self.bus.attach(0x69, RegisterSlave(refuses_from=1))
        stretching = RegisterSlave()
        stretching.stretch_ns = 30 * MS  # type: ignore[attr-defined]
        self.bus.attach(0x6A, stretching)


class Collector:
    """A UART peer that keeps everything."""

    def __init__(self) -> None:
        self.chunks: list[tuple[int, bytes]] = []

    def receive(self, data: bytes, time_ns: int) -> None:
        self.chunks.append((time_ns, data))

    @property
    def data(self) -> bytes:
        return b"".join(data for _, data in self.chunks)


class EmulatedSerial:
    def __init__(self) -> None:
        self.cpu = processor("rx")
        self._tx = UartWire(self.cpu.time, 115_200, "tx", capacity=512)
        self._rx = UartWire(self.cpu.time, 115_200, "rx")
        self._far_end = Collector()
        self._tx.connect(self._far_end)
        self.port = EmulatedUart(self.cpu, self._tx, self._rx)

    def line(self, handler: Callable[[], None]) -> EmulatedLine:
        return self.cpu.attach("rx", handler)

    def expect(self, data: bytes) -> None:
        pass

    def feed(self, data: bytes) -> None:
        self._rx.send(data)

    def settle(self) -> None:
        self.cpu.delay(100 * MS)

    def sent(self) -> bytes:
        return self._far_end.data


class EmulatedCan:
    def __init__(self) -> None:
        cpu = processor()
        bus = EmulatedCanBus(cpu.time, 500_000)
        self.controller = EmulatedCanController(cpu, bus)
        self._other = CanNode(bus)
        self._cpu = cpu
        self._sent: list[CanFrame] = []
        self._other.deliver = lambda frame, _end: self._sent.append(frame)  # type: ignore[method-assign]

    def expect(self, frames: Sequence[CanFrame]) -> None:
        pass

    def feed(self, frame: CanFrame) -> None:
        self._other.send((frame,))

    def settle(self) -> None:
        self._cpu.delay(10 * MS)

    def sent(self) -> list[CanFrame]:
        return self._sent


class EmulatedPins:
    def __init__(self) -> None:
        self._cpu = processor("pin")
        net = Net(self._cpu.time, "JUMPER")
        self.output = EmulatedOutputPin(self._cpu, net)
        self.input = EmulatedInputPin(self._cpu, net)

    def line(self, handler: Callable[[], None]) -> EmulatedLine:
        return self._cpu.attach("pin", handler)

    def expect(self, level: bool) -> None:
        pass

    def settle(self) -> None:
        self._cpu.spend(1)


class EmulatedInterrupts:
    nests = True
    knows_names = True

    def __init__(self) -> None:
        self.cpu = self.controller = processor("urgent", "middle", "background")

    def settle(self) -> None:
        self.cpu.spend(1000)


class EmulatedClock:
    tolerance = 1e-4

    def __init__(self) -> None:
        self.cpu = self.clock = processor(crystal_error_ppb=-80_000)

    def expect_delay(self, duration_ns: int) -> None:
        pass


class EmulatedTimers:
    def __init__(self) -> None:
        self._cpu = processor("timer", "capture", crystal_error_ppb=20_000)
        self._net = Net(self._cpu.time, "PPS")
        self.timer = EmulatedPeriodicTimer(self._cpu)
        self.capture = EmulatedCaptureTimer(self._cpu, self._net)

    def line(self, name: str, handler: Callable[[], None]) -> EmulatedLine:
        return self._cpu.attach(name, handler)

    def expect(self, action: str) -> None:
        pass

    def wait(self, duration_ns: int, expiries: int) -> None:
        self._cpu.delay(duration_ns)

    def edge(self) -> int | None:
        self._cpu.delay(MS)
        at = self._cpu.clock_at(self._cpu.time.now)
        self._net.set(True)
        self._cpu.delay(MS)
        self._net.set(False)
        return at


class EmulatedStorage:
    def __init__(self) -> None:
        self._safe: list[bytes] = []
        self.log = EmulatedLogFile(processor(), self._safe.append)
        self.cut_power: Callable[[], None] | None = self.log.power_cut
        self.remove_card: Callable[[], None] | None = self.log.remove

    def expect(self, action: str) -> None:
        pass

    def contents(self) -> bytes:
        return b"".join(self._safe)


class EmulatedWatchdogBench:
    def __init__(self) -> None:
        self._cpu = processor()
        self._bitten = False
        self.watchdog = EmulatedWatchdog(self._cpu)

    def wait(self, duration_ns: int) -> None:
        try:
            self._cpu.delay(duration_ns)
        except ProcessorReset:
            self._bitten = True

    def bitten(self) -> bool:
        return self._bitten
