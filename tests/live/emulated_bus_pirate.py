"""An emulated Bus Pirate: what its documentation says of the binary modes, byte by byte.

Written from the protocol's description (bitbang, binary SPI, binary I2C), not from the client under test.
Each mode is a generator that is sent one byte after the other. What a chip model answers to a transfer is
asked for when chip select rises or no more input is there, whichever comes first, since the models want a
whole transfer at once and a client may wait for its bytes before it lets go of chip select.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Generator
from typing import Protocol

from hal.emulated.virtual_time import VirtualTime

BANNER = "\r\nBus Pirate v3.5\r\nFirmware {}\r\nHiZ>"
TERMINAL_BUFFER = 4096
SPI_HZ = (30_000, 125_000, 250_000, 1_000_000, 2_000_000, 2_600_000, 4_000_000, 8_000_000)
I2C_HZ = (5_000, 50_000, 100_000, 400_000)

Mode = Generator[None, int, None]


class SpiChip(Protocol):
    def transaction(self, mosi: bytes | bytearray, start_ns: int, end_ns: int) -> bytes: ...


class I2cChip(Protocol):
    def write(self, data: bytes, time_ns: int) -> int: ...

    def read(self, length: int, time_ns: int) -> bytes: ...


class WallTime:
    """Drives the virtual time of chip models by the clock on the wall."""

    def __init__(self) -> None:
        self.virtual = VirtualTime()
        self._began = time.monotonic_ns()

    def advance(self) -> int:
        now = time.monotonic_ns() - self._began
        while self.virtual.next_due <= now:
            self.virtual.run_next()
        self.virtual.now = max(self.virtual.now, now)
        return self.virtual.now


class EmulatedBusPirate:
    """One bridge; `feed` gets bytes from its serial line and returns what it answers."""

    def __init__(
        self,
        wall: WallTime | None = None,
        spi: SpiChip | None = None,
        i2c: dict[int, I2cChip] | None = None,
        supply: Callable[[bool], None] | None = None,
        modes: str = "SPI I2C",
        firmware: str = "v7.1",
    ) -> None:
        self.wall = wall or WallTime()
        self.spi = spi
        self.i2c = i2c or {}
        self.modes = modes
        self.banner = BANNER.format(firmware).encode()
        self._supply = supply
        self.power = self.pull_ups = self.aux = False
        self.cs = True
        self.speed_hz = 0
        self.spi_config = 0
        self.transfers: list[tuple[bytes, bytes]] = []
        """(MOSI, MISO) of every chip select low period."""
        self._out = bytearray()
        self._input = bytearray()
        self._mosi = bytearray()
        self._miso = bytearray()
        self._owed: list[int] = []
        """Places in `_out` of SPI bytes that the chip has not been asked for yet."""
        self._selected_at = 0
        self._mode: Mode = self._begin(self._terminal())

    # -- the serial line -------------------------------------------------------------------------

    def feed(self, data: bytes) -> bytes:
        self._input += data
        while self._input:
            byte = self._input.pop(0)
            self._mode.send(byte)
        self._pay()
        out = bytes(self._out)
        self._out.clear()
        return out

    def reset(self) -> bytes:
        """The reset button, or a brown-out: returns what it prints."""
        self._outputs_off()
        self._input.clear()
        self._owed.clear()
        self._out.clear()
        self._mode = self._begin(self._terminal())
        return self.banner

    @staticmethod
    def _begin(mode: Mode) -> Mode:
        next(mode)
        return mode

    # -- modes -----------------------------------------------------------------------------------

    def _terminal(self) -> Mode:
        zeros = 0
        while True:
            byte = yield
            zeros = zeros + 1 if byte == 0 else 0
            if byte:
                self._out.append(byte)  # echo
            if byte == 0x0D:
                self._out += b"\nHiZ>"
            if zeros == 20:
                zeros = 0
                yield from self._bitbang()
                self._out += self.banner

    def _bitbang(self) -> Mode:
        self._outputs_off()
        self._out += b"BBIO1"
        while True:
            byte = yield
            if byte == 0x00:
                self._out += b"BBIO1"
            elif byte == 0x01 and "SPI" in self.modes:
                yield from self._spi()
                self._out += b"BBIO1"
            elif byte == 0x02 and "I2C" in self.modes:
                yield from self._i2c()
                self._out += b"BBIO1"
            elif byte == 0x0F:
                self._outputs_off()
                self._out.append(1)
                return
            else:
                self._out.append(0)

    def _spi(self) -> Mode:
        self.speed_hz, self.spi_config = SPI_HZ[1], 0x02
        self._out += b"SPI1"
        while True:
            byte = yield
            kind, low = byte >> 4, byte & 0x0F
            if byte == 0x00:
                self._pay()
                self._outputs_off()
                return
            if byte == 0x01:
                self._out += b"SPI1"
            elif byte in (0x02, 0x03):
                self._select(byte == 0x02)
                self._out.append(1)
            elif byte in (0x04, 0x05):
                yield from self._write_then_read(with_cs=byte == 0x04)
            elif kind == 0x1:
                self._out.append(1)
                for _ in range(low + 1):
                    self._mosi.append((yield))
                    self._owed.append(len(self._out))
                    self._out.append(0xEE)
            elif kind == 0x4:
                self._peripherals(low)
            elif kind == 0x6 and low < 8:
                self.speed_hz = SPI_HZ[low]
                self._out.append(1)
            elif kind == 0x8:
                self.spi_config = low
                self._out.append(1)
            else:
                self._out.append(0)

    def _write_then_read(self, with_cs: bool) -> Mode:
        head = [(yield), (yield), (yield), (yield)]
        to_write, to_read = head[0] << 8 | head[1], head[2] << 8 | head[3]
        if to_write > TERMINAL_BUFFER or to_read > TERMINAL_BUFFER:
            self._out.append(0)
            return
        data = bytearray()
        for _ in range(to_write):
            data.append((yield))
        if with_cs:
            self._select(True)
        self._mosi += data + b"\xff" * to_read
        places = len(self._miso) + to_write
        self._pay()
        answer = self._miso[places:]
        if with_cs:
            self._select(False)
        self._out.append(1)
        self._out += answer

    def _i2c(self) -> Mode:
        self.speed_hz = I2C_HZ[3]
        bus = _I2cWire(self)
        self._out += b"I2C1"
        while True:
            byte = yield
            kind, low = byte >> 4, byte & 0x0F
            if byte == 0x00:
                self._outputs_off()
                return
            if byte == 0x01:
                self._out += b"I2C1"
            elif byte == 0x02:
                bus.start()
                self._out.append(1)
            elif byte == 0x03:
                bus.stop()
                self._out.append(1)
            elif byte == 0x04:
                self._out.append(bus.read(self._reads_ahead()))
            elif byte in (0x06, 0x07):
                self._out.append(1)
            elif kind == 0x1:
                self._out.append(1)
                for _ in range(low + 1):
                    self._out.append(0 if bus.write((yield)) else 1)
            elif kind == 0x4:
                self._peripherals(low)
            elif kind == 0x6 and low < 4:
                self.speed_hz = I2C_HZ[low]
                self._out.append(1)
            else:
                self._out.append(0)

    # -- pins ------------------------------------------------------------------------------------

    def _peripherals(self, wxyz: int) -> None:
        self.power, self.pull_ups = bool(wxyz & 8), bool(wxyz & 4)
        self.aux, self.cs = bool(wxyz & 2), bool(wxyz & 1)
        self._feed_chip()
        self._out.append(1)

    def _outputs_off(self) -> None:
        self.power = self.pull_ups = self.aux = False
        self.cs = True
        self._feed_chip()

    def _feed_chip(self) -> None:
        if self._supply is not None:
            self.wall.advance()
            self._supply(self.power)

    # -- SPI -------------------------------------------------------------------------------------

    def _select(self, low: bool) -> None:
        self._pay()
        if self._mosi:
            self.transfers.append((bytes(self._mosi), bytes(self._miso)))
        self._mosi.clear()
        self._miso.clear()
        self.cs = not low
        self._selected_at = self.wall.advance()

    def _pay(self) -> None:
        """Ask the chip for the bytes that the line is owed."""
        if len(self._miso) == len(self._mosi):
            return
        end = self._selected_at + len(self._mosi) * 8 * 1_000_000_000 // max(1, self.speed_hz)
        if self.spi is None or self.cs or not self.power:
            miso = b"\xff" * len(self._mosi)
        else:
            miso = self.spi.transaction(bytes(self._mosi), self._selected_at, end)
        new = miso[len(self._miso) :]
        for place, byte in zip(self._owed, new, strict=False):
            self._out[place] = byte
        self._owed.clear()
        self._miso += new

    def _reads_ahead(self) -> int:
        """How many bytes will be read in a row, as far as the input tells: read, acknowledge, read …"""
        count = 1
        ahead = self._input
        while ahead[2 * count - 2 : 2 * count] == b"\x06\x04":
            count += 1
        return count


class _I2cWire:
    """Start, bytes, stop; chips hear of a write when it is over."""

    def __init__(self, pirate: EmulatedBusPirate) -> None:
        self._pirate = pirate
        self._chip: I2cChip | None = None
        self._addressed = False
        self._reading = False
        self._written = bytearray()
        self._data = b""

    def start(self) -> None:
        self._finish()

    def stop(self) -> None:
        self._finish()

    def write(self, byte: int) -> bool:
        """Returns whether it is acknowledged."""
        if not self._addressed:
            self._addressed = True
            powered = self._pirate.power and self._pirate.pull_ups
            self._chip = self._pirate.i2c.get(byte >> 1) if powered else None
            self._reading = bool(byte & 1)
            return self._chip is not None
        if self._chip is None:
            return False
        self._written.append(byte)
        return len(self._written) <= getattr(self._chip, "refuses_from", 1 << 30)

    def read(self, ahead: int) -> int:
        if self._chip is None or not self._reading:
            return 0xFF
        if not self._data:
            self._data = self._chip.read(ahead, self._pirate.wall.advance())
        byte, self._data = self._data[0], self._data[1:]
        return byte

    def _finish(self) -> None:
        if self._chip is not None and self._written:
            accepted = min(len(self._written), getattr(self._chip, "refuses_from", 1 << 30))
            self._chip.write(bytes(self._written[:accepted]), self._pirate.wall.advance())
        self._written.clear()
        self._chip = None
        self._addressed = False
        self._data = b""
