"""From what was asked for to a chip with its driver on a bridge: known chips, buses, addresses, records."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

from firmware.drivers.adxl345 import Adxl345Config
from firmware.drivers.adxl345_ports import I2cPort, SpiPort
from firmware.drivers.bmi160 import Bmi160Config
from hal.cpu import Cpu
from hal.i2c import I2cBus
from hal.live.bridge_session import BridgeCounters
from hal.live.bus_pirate import BusPirateError
from hal.live.bus_pirate_buses import I2C_SPEEDS, SPI_SPEEDS, BusPirateI2c, BusPirateSpi
from hal.live.cpu import LiveCpu
from hal.live.port import PortError, is_device
from hal.scripted import ScriptedCpu, ScriptedI2c, ScriptedSpi, Transcript
from hal.scripted.recording import Recording
from hal.spi import SpiDevice
from host.attach.chip_adxl345 import Adxl345OnDesk
from host.attach.chip_bmi160 import Bmi160OnDesk, RegistersOverI2c
from host.attach.chip_on_desk import ChipOnDesk
from host.attach.chip_pace import RealPace, RecordedPace
from host.attach.chip_session import ChipSession
from host.record.errors import UserError

ADDRESSES = {"bmi160": (0x68, 0x69), "adxl345": (0x53, 0x1D)}
"""The chip's I²C addresses, the usual one first."""
SPI_MODE = {"bmi160": 0, "adxl345": 3}
BUSES = ("spi", "i2c")
DEFAULT_SPEED_HZ = {"spi": 1_000_000, "i2c": 400_000}
SPEEDS = {"spi": SPI_SPEEDS, "i2c": I2C_SPEEDS}
FASTEST_SPI_HZ = {"bmi160": 10_000_000, "adxl345": 5_000_000}
RECORD_NAME = "imu"


@dataclass(frozen=True, slots=True)
class ChipRequest:
    """What was asked for. Raises UserError for what cannot be."""

    chip: str
    port: str
    bus: str = "spi"
    address: int | None = None
    speed_hz: int | None = None
    rate_hz: float = 100.0
    power: bool = True
    record: Path | None = None

    def __post_init__(self) -> None:
        if self.chip not in ADDRESSES:
            raise UserError(f"there is no driver for a chip {self.chip!r}; there are: {', '.join(ADDRESSES)}")
        if self.bus not in BUSES:
            raise UserError(f"--bus {self.bus}: possible are {' and '.join(BUSES)}")
        if self.address is not None and self.bus == "spi":
            raise UserError("--address is for --bus i2c; on SPI the chip select tells which chip is meant")
        allowed = ADDRESSES[self.chip]
        if self.address is not None and self.address not in allowed:
            names = ", ".join(f"0x{one:02x}" for one in allowed)
            raise UserError(f"--address 0x{self.address:02x}: a {self.chip} has one of {names}")
        _check_rate(self.chip, self.rate_hz)
        fastest = FASTEST_SPI_HZ[self.chip]
        speeds = [speed for speed in SPEEDS[self.bus] if speed <= fastest]
        if self.speed_hz is not None and self.speed_hz not in speeds:
            names = ", ".join(map(str, speeds))
            raise UserError(
                f"--speed {self.speed_hz}: for a {self.chip} the bridge's {self.bus} has {names} Hz"
            )

    @property
    def bus_text(self) -> str:
        """Bus, speed and address for people."""
        speed = (self.speed_hz or DEFAULT_SPEED_HZ[self.bus]) / 1000
        where = f"I²C at 0x{self.i2c_address:02x}" if self.bus == "i2c" else "SPI"
        return f"{where}, {speed:,.0f} kHz"

    @property
    def i2c_address(self) -> int:
        """7 bits."""
        return self.address or ADDRESSES[self.chip][0]


@contextmanager
def chip_session(request: ChipRequest) -> Iterator[ChipSession]:
    """The bridge open and set up, or the record, and the chip not yet started. Raises UserError.

    A record that is written is renamed into place when this ends without an exception.
    """
    if is_device(request.port) and Path(request.port).is_file():
        with _replay(request) as session:
            yield session
        return
    cpu = LiveCpu()
    with _record(request) as recording:
        bus = _open_bus(request, cpu)
        try:
            clock: Cpu = recording.cpu(cpu) if recording else cpu
            if isinstance(bus, BusPirateSpi):
                device: SpiDevice = recording.spi(RECORD_NAME, bus) if recording else bus
                chip = _chip_on_spi(request, device, clock)
            else:
                wires: I2cBus = recording.i2c(RECORD_NAME, bus) if recording else bus
                chip = _chip_on_i2c(request, wires, clock)
            yield ChipSession(chip, RealPace(cpu), bus.session.counters)
        finally:
            bus.close()


@contextmanager
def _replay(request: ChipRequest) -> Iterator[ChipSession]:
    """A record in the place of the bridge."""
    if request.record is not None:
        raise UserError(f"--record: {request.port} is a record already")
    try:
        text = Path(request.port).read_text()
        whole = text[: text.rfind("\n") + 1]  # whoever wrote it may have been killed
        transcript = Transcript(whole)
    except (OSError, ValueError) as error:
        raise UserError(f"--port {request.port}: is not a record of --record: {error}") from None
    cpu = ScriptedCpu(transcript)
    if request.bus == "spi":
        chip = _chip_on_spi(request, ScriptedSpi(transcript, RECORD_NAME), cpu)
    else:
        chip = _chip_on_i2c(request, ScriptedI2c(transcript, RECORD_NAME), cpu)
    pace = RecordedPace(transcript)
    session = ChipSession(chip, pace, BridgeCounters())
    try:
        yield session
    except (AssertionError, ValueError) as difference:
        if not pace.is_over():
            told = "; ".join(" ".join(line.split()) for line in str(difference).splitlines()[:3])
            raise UserError(
                f"--port {request.port}: the record was made otherwise (chip, bus, rate or driver): {told}"
            ) from None
        if not session.started:
            raise UserError(f"--port {request.port}: the record ends before the chip was set up") from None


def _open_bus(request: ChipRequest, cpu: LiveCpu) -> BusPirateSpi | BusPirateI2c:
    speed = request.speed_hz or DEFAULT_SPEED_HZ[request.bus]
    try:
        if request.bus == "i2c":
            return BusPirateI2c(cpu, request.port, speed, request.power)
        return BusPirateSpi(cpu, request.port, speed, SPI_MODE[request.chip], request.power)
    except (PortError, BusPirateError) as error:
        raise UserError(f"--port {error}") from None


def _chip_on_spi(request: ChipRequest, device: SpiDevice, cpu: Cpu) -> ChipOnDesk:
    if request.chip == "adxl345":
        return Adxl345OnDesk(SpiPort(device), cpu, request.rate_hz)
    return Bmi160OnDesk(device, cpu, int(request.rate_hz))


def _chip_on_i2c(request: ChipRequest, bus: I2cBus, cpu: Cpu) -> ChipOnDesk:
    if request.chip == "adxl345":
        return Adxl345OnDesk(I2cPort(bus, request.i2c_address), cpu, request.rate_hz)
    return Bmi160OnDesk(RegistersOverI2c(bus, request.i2c_address), cpu, int(request.rate_hz))


def _check_rate(chip: str, rate_hz: float) -> None:
    """Before any hardware is touched."""
    try:
        if chip == "adxl345":
            Adxl345Config(rate_hz=rate_hz)
        else:
            Bmi160Config(rate_hz=int(rate_hz) if rate_hz.is_integer() else -1)
    except ValueError as error:
        reason = str(error).partition("possible: ")[2]
        raise UserError(f"--rate {rate_hz:g}: a {chip} has {reason} Hz") from None


@contextmanager
def _record(request: ChipRequest) -> Iterator[Recording | None]:
    path = request.record
    if path is None:
        yield None
        return
    part = path.with_name(path.name + ".part")
    if path.is_dir():
        raise UserError(f"--record {path}: is a folder; name a file, e.g. {path / 'desk.txt'}")
    try:
        file: TextIO = part.open("w")
    except OSError as error:
        raise UserError(f"--record {path}: cannot be written: {error.strerror}") from None
    try:
        with file:
            recording = Recording(file)
            recording.comment(f"{request.chip} over {request.bus_text}, {request.rate_hz:g} samples/s")
            yield recording
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
