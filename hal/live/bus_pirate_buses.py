"""SPI and I²C of a Bus Pirate, and its AUX pin.

    MOSI, SDA   MOSI of the bridge        CS      CS
    CLK, SCL    CLK                       AUX     AUX, an output
    MISO        MISO                      supply  3V3

SPI: one transaction is chip select low, exchanges of up to 16 bytes, chip select high, in one round trip.
I²C: start, bytes, repeated start, reads and stop go out together; when the address or a byte is refused the
rest has been clocked nevertheless, reading an idle bus.
"""

from __future__ import annotations

from hal.errors import BusError, ErrorKind
from hal.live.bridge_session import BridgeSession
from hal.live.bus_pirate import AUX, CS, ENTER_I2C, ENTER_SPI, OK, PERIPHERALS, POWER, PULL_UPS
from hal.live.cpu import LiveCpu

SPI_SPEEDS = {125_000: 1, 250_000: 2, 1_000_000: 3, 2_000_000: 4, 2_600_000: 5, 4_000_000: 6, 8_000_000: 7}
"""Hz. 30 kHz, which the bridge has too, is slower than its serial line."""
I2C_SPEEDS = {100_000: 2, 400_000: 3}
"""Hz. 5 and 50 kHz are slower than its serial line."""
SPI_MODES = {0: 0x02, 1: 0x00, 2: 0x06, 3: 0x04}
"""Clock polarity and edge of the four modes: bit 2 idles high, bit 1 changes data from active to idle."""
SET_SPEED = 0x60
SET_SPI = 0x80
OUTPUT_3V3 = 0x08

CS_LOW = 0x02
CS_HIGH = 0x03
BULK = 0x10
BULK_BYTES = 16
START = 0x02
STOP = 0x03
READ_BYTE = 0x04
ACKNOWLEDGE = 0x06
REFUSE = 0x07
FLOATING = 0xFF


class BusPirateSpi:
    """Implements `hal.spi.SpiDevice` on the bridge's one chip select.

    While the bridge does not answer, the buffer comes back as 0xFF, as from a line without a slave.
    """

    def __init__(
        self, cpu: LiveCpu, url: str, speed_hz: int = 1_000_000, mode: int = 0, power: bool = True
    ) -> None:
        _one_of(f"SPI speed of a Bus Pirate on {url}", speed_hz, SPI_SPEEDS)
        _one_of(f"SPI mode of a Bus Pirate on {url}", mode, SPI_MODES)
        settings = (
            SET_SPI | OUTPUT_3V3 | SPI_MODES[mode],
            SET_SPEED | SPI_SPEEDS[speed_hz],
            PERIPHERALS | CS | (POWER if power else 0),
        )
        self.session = BridgeSession(url, ENTER_SPI, b"SPI1", settings)
        self._cpu = cpu
        self._byte_s = 8.0 / speed_hz

    def transaction(self, buffer: bytearray) -> None:
        """Exchange the whole buffer in place, most significant bit first."""
        self._cpu.safe_point()
        length = len(buffer)
        request = bytearray((CS_LOW,))
        for start in range(0, length, BULK_BYTES):
            piece = buffer[start : start + BULK_BYTES]
            request.append(BULK | len(piece) - 1)
            request += piece
        request.append(CS_HIGH)
        reply = self.session.exchange(bytes(request), length * self._byte_s)
        miso = _exchanged(reply, length) if reply is not None else None
        if reply is not None and miso is None:
            self.session.out_of_step(f"answers {reply.hex(' ')} to a transaction")
        buffer[:] = miso if miso is not None else bytes((FLOATING,)) * length
        self._cpu.safe_point()

    def close(self) -> None:
        """Switch the bridge's outputs off and let go of the port."""
        self.session.close()


class BusPirateI2c:
    """Implements `hal.i2c.I2cBus`. CS is held high, which keeps the common sensors in their I²C mode.

    While the bridge does not answer, transactions raise BusError of kind TIMEOUT.
    """

    def __init__(
        self,
        cpu: LiveCpu,
        url: str,
        speed_hz: int = 400_000,
        power: bool = True,
        pull_ups: bool = True,
    ) -> None:
        _one_of(f"I2C speed of a Bus Pirate on {url}", speed_hz, I2C_SPEEDS)
        settings = (
            SET_SPEED | I2C_SPEEDS[speed_hz],
            PERIPHERALS | CS | (POWER if power else 0) | (PULL_UPS if pull_ups else 0),
        )
        self.session = BridgeSession(url, ENTER_I2C, b"I2C1", settings)
        self._cpu = cpu
        self._byte_s = 9.0 / speed_hz

    def transaction(self, address: int, write: bytes = b"", read_length: int = 0) -> bytes:
        """Run one transaction and return the bytes read."""
        self._cpu.safe_point()
        request = _Request()
        if write or not read_length:
            request.start_and_send(bytes((address << 1,)) + write)
        if read_length:
            request.start_and_send(bytes((address << 1 | 1,)))
            request.read(read_length)
        request.command(STOP)
        clocked = len(write) + read_length + 2
        reply = self.session.exchange(bytes(request.sent), clocked * self._byte_s)
        self._cpu.safe_point()
        if reply is None:
            raise BusError(
                ErrorKind.TIMEOUT, f"the bridge {self.session.url} does not answer: {self._problem()}"
            )
        return self._read_out(address, request, reply)

    def close(self) -> None:
        """Switch the bridge's outputs off and let go of the port."""
        self.session.close()

    def _read_out(self, address: int, request: _Request, reply: bytes) -> bytes:
        if any(reply[at] != OK for at in request.confirmed) or any(reply[at] > 1 for at in request.bits):
            self.session.out_of_step(f"answers {reply.hex(' ')} to a transaction")
            raise BusError(ErrorKind.OTHER, f"the bridge {self.session.url} {self._problem()}")
        refused = [number for number, at in enumerate(request.bits) if reply[at]]
        if refused:
            first = refused[0]
            if first in request.addresses:
                raise BusError(ErrorKind.ADDRESS_NACK, f"nobody at 0x{address:02X} on {self.session.url}")
            raise BusError(
                ErrorKind.DATA_NACK, f"byte {first} to 0x{address:02X} on {self.session.url} was refused"
            )
        return bytes(reply[at] for at in request.data)

    def _problem(self) -> str:
        return self.session.counters.last_problem


class BusPirateAux:
    """Implements `hal.pins.OutputPin` on the AUX pin of a bridge that is in SPI or I²C mode."""

    def __init__(self, cpu: LiveCpu, session: BridgeSession) -> None:
        self._cpu = cpu
        self._session = session

    def set(self, level: bool) -> None:
        """Drive the electrical level; a bridge that is away does so when it is back."""
        self._cpu.safe_point()
        others = self._session.setting(PERIPHERALS) & ~AUX
        self._session.set(others | (AUX if level else 0))


class _Request:
    """The commands of an I²C transaction, and what each byte of the reply will be."""

    def __init__(self) -> None:
        self.sent = bytearray()
        self.confirmed: list[int] = []
        """Places of the reply where 01 must stand."""
        self.bits: list[int] = []
        """Places of acknowledge bits, 0: acknowledged."""
        self.addresses: set[int] = set()
        """Which of the bits answer an address."""
        self.data: list[int] = []
        """Places of bytes read."""

    def command(self, command: int) -> None:
        self.confirmed.append(len(self.sent))
        self.sent.append(command)

    def start_and_send(self, data: bytes) -> None:
        self.command(START)
        self.addresses.add(len(self.bits))
        for start in range(0, len(data), BULK_BYTES):
            piece = data[start : start + BULK_BYTES]
            self.command(BULK | len(piece) - 1)
            self.bits += range(len(self.sent), len(self.sent) + len(piece))
            self.sent += piece

    def read(self, length: int) -> None:
        for left in range(length, 0, -1):
            self.data.append(len(self.sent))
            self.sent.append(READ_BYTE)
            self.command(ACKNOWLEDGE if left > 1 else REFUSE)


def _exchanged(reply: bytes, length: int) -> bytes | None:
    """MISO out of the reply to an SPI transaction; None when a confirmation is missing."""
    if reply[0] != OK or reply[-1] != OK:
        return None
    miso = bytearray()
    for start in range(1, len(reply) - 1, BULK_BYTES + 1):
        piece = reply[start : min(start + BULK_BYTES + 1, len(reply) - 1)]
        if piece[0] != OK:
            return None
        miso += piece[1:]
    return bytes(miso) if len(miso) == length else None


def _one_of(what: str, value: int, allowed: dict[int, int]) -> None:
    if value not in allowed:
        raise ValueError(f"{what} is {value!r}; possible: {', '.join(map(str, allowed))}")
