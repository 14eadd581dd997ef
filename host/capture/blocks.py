"""Blocks of raw wire traffic: many small records in one message. Byte tables stand in docs/capture.md.

All numbers are little endian, records follow one another without padding:

    SPI     start_ns i64 | duration_ns u32 | n u32 | n bytes MOSI | n bytes MISO
    line    told_ns i64 | start_ns i64 | first u32 | baud u32 | n u32 | n bytes
    sent    end_ns i64 | baud u32, 0: not known | n u32 | n bytes
    UART    the same without baud (captures of formats 1 to 3, imported logs)
    I²C     start_ns i64 | end_ns i64 | address u8 | refusal u8 | n, acknowledged, asked, m u32
            | n bytes written | m bytes read
    CAN     end_ns i64 | identifier u32, bit 31: 29-bit identifier | n u8 | s u8 | n bytes | s bytes: sender
    CAN-2   the same without s and sender (captures of format 2)
    pin     2·time_ns + level i64
    mark    time_ns i64

Times are virtual time in ns. A SPI record is one chip-select low period; an I²C record goes from start to
stop condition (`REFUSALS` has the meaning of `refusal`). A line record tells the receiving end of a UART what
was put on the line at `told_ns`: bytes `first`, `first` + 1, … of a run that began at `start_ns`, so that
byte k of the record ends at start_ns + ⌊(first + k + 1)·10¹⁰ / baud⌋; with `baud` 0 it takes back whatever
begins at `start_ns` or later. The upper two bits of `baud` are a place in `FORMS`: stop bits low, a parity
bit more (11·10⁹ in the formula), not taken in time. A sent record is a run of bytes, of which the last one
ended at `end_ns`; a CAN record is a data frame that ended on the bus at `end_ns`; a pin record is a change of
a net's level. A mark says that everything up to its time is in the file.
"""

from __future__ import annotations

import functools
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hal.emulated.can_bursts import HeardFrame, HeardSets
from hal.emulated.i2c import I2cTransfer
from hal.emulated.uart_bytes import FORMS
from hal.errors import ErrorKind
from host.record.errors import UserError

SPI_HEAD = struct.Struct("<qII")
UART_HEAD = struct.Struct("<qI")
SENT_HEAD = struct.Struct("<qII")
I2C_HEAD = struct.Struct("<qqBBIIII")
CAN_HEAD = struct.Struct("<qIB")
SENT_CAN_HEAD = struct.Struct("<qIBB")
LINE_HEAD = struct.Struct("<qqIII")
FORM_SHIFT = 30
LINE_BAUD = (1 << FORM_SHIFT) - 1
PIN = MARK = struct.Struct("<q")
FIRST_TIME = struct.Struct("<q")

EXTENDED = 1 << 31
WORTH_ARRAYS = 50
"""CAN records from which on arrays are faster than a record at a time."""
FULL_CAN_RECORD = np.dtype([("end_ns", "<i8"), ("identifier", "<u4"), ("n", "u1"), ("data", "S8")])
"""A CAN record of eight bytes."""

REFUSALS: tuple[ErrorKind | None, ...] = (
    None,
    ErrorKind.ADDRESS_NACK,
    ErrorKind.DATA_NACK,
    ErrorKind.TIMEOUT,
    ErrorKind.OTHER,
)
"""How an I²C transaction ended: well, nobody at the address, a byte refused, clock held, broken off."""

ENCODING = "x-navtwin-block"
CAN_SCHEMA, OLD_CAN_SCHEMA = "navtwin.CanFrameBlock", "navtwin.CanBlock"
SENT_SCHEMA, OLD_SENT_SCHEMA = "navtwin.SentBlock", "navtwin.UartBlock"

SCHEMAS = {
    "navtwin.SpiBlock": "start_ns i64, duration_ns u32, n u32, mosi u8[n], miso u8[n]; repeated",
    "navtwin.LineBlock": "told_ns i64, start_ns i64, first u32, baud u32 (bits 31, 30: form), n u32,"
    " data u8[n]; repeated",
    "navtwin.SentBlock": "end_ns i64, baud u32 (0: not known), n u32, data u8[n]; repeated",
    "navtwin.UartBlock": "end_ns i64, n u32, data u8[n]; repeated",
    "navtwin.I2cBlock": "start_ns i64, end_ns i64, address u8, refusal u8 (0 none, 1 address, 2 data,"
    " 3 timeout, 4 broken off), n u32, acknowledged u32, asked u32, m u32, written u8[n], read u8[m];"
    " repeated",
    "navtwin.CanFrameBlock": "end_ns i64, identifier u32 (bit 31: extended), n u8, s u8, data u8[n],"
    " sender u8[s]; repeated",
    "navtwin.CanBlock": "end_ns i64, identifier u32 (bit 31: extended), n u8, data u8[n]; repeated",
    "navtwin.PinBlock": "2*time_ns+level i64; repeated",
    "navtwin.Mark": "time_ns i64: everything up to here is in the file",
}


@dataclass(frozen=True, slots=True)
class SpiTransaction:
    """One chip-select low period of an SPI bus."""

    bus: str
    start_ns: int
    end_ns: int
    mosi: bytes
    miso: bytes


@dataclass(frozen=True, slots=True)
class I2cTransaction:
    """One transaction of an I²C bus."""

    bus: str
    transfer: I2cTransfer


@dataclass(frozen=True, slots=True)
class UartChunk:
    """Bytes on one direction of a UART ("rx" into the processor, "tx" out of it)."""

    port: str
    direction: str
    end_ns: int
    data: bytes
    baud: int | None = None
    """None: not recorded."""


@dataclass(frozen=True, slots=True)
class CanMessage:
    """A data frame on a CAN bus."""

    bus: str
    end_ns: int
    identifier: int
    extended: bool
    data: bytes
    sender: str | None = None
    """None: not recorded."""


@dataclass(frozen=True, slots=True)
class LinePiece:
    """Bytes on the line into a processor's UART, at the rate at which they were sent."""

    port: str
    told_ns: int
    """When they were queued."""
    start_ns: int
    first: int
    baud: int
    data: bytes
    form: int = 0
    """Place in `hal.emulated.uart_bytes.FORMS`."""

    @property
    def end_ns(self) -> int:
        """End of the last byte's stop bit."""
        return self.start_ns + (self.first + len(self.data)) * FORMS[self.form].frame // self.baud


@dataclass(frozen=True, slots=True)
class LineCut:
    """The transmitter stopped: bytes told before that begin at `begin_ns` or later did not come."""

    port: str
    told_ns: int
    begin_ns: int


@dataclass(frozen=True, slots=True)
class PinEdge:
    """A change of a net's level."""

    net: str
    time_ns: int
    level: bool


@dataclass(frozen=True, slots=True)
class Mark:
    """Everything up to `time_ns` has been read."""

    time_ns: int


Traffic = SpiTransaction | I2cTransaction | LinePiece | LineCut | UartChunk | CanMessage | PinEdge | Mark


class DamagedBlockError(UserError, ValueError):
    """A block is not what its schema says."""


def unpack(schema: str, topic: str, block: bytes) -> Iterator[Traffic]:
    """The records of one block, in their order. DamagedBlockError when the block ends inside a record."""
    for record, _begin, _end in spans(schema, topic, block):
        yield record


def spans(schema: str, topic: str, block: bytes) -> Iterator[tuple[Traffic, int, int]]:
    """The records of one block with their places in it, [begin, end). DamagedBlockError as `unpack`."""
    read = READERS[schema]
    place = 0
    while place < len(block):
        try:
            record, end = read(topic, block, place)
        except struct.error:
            end = len(block) + 1
        except DamagedBlockError:
            raise
        except (IndexError, ValueError) as error:
            raise DamagedBlockError(f"{topic}: no topic of {schema}: {error}") from None
        if end > len(block):
            raise DamagedBlockError(
                f"{topic}: a block of {len(block)} bytes ends inside the record at byte {place}"
            )
        yield record, place, end
        place = end


def time_of(record: Traffic) -> int:
    """When a record belongs into the file: ns."""
    match record:
        case SpiTransaction():
            return record.start_ns
        case I2cTransaction():
            return record.transfer.start_ns
        case LinePiece() | LineCut():
            return record.told_ns
        case PinEdge() | Mark():
            return record.time_ns
        case _:
            return record.end_ns


def i2c_record(done: I2cTransfer) -> bytes:
    """Record of an I²C transaction."""
    head = I2C_HEAD.pack(
        done.start_ns,
        done.end_ns,
        done.address,
        REFUSALS.index(done.refusal),
        len(done.written),
        done.acknowledged,
        done.asked,
        len(done.read),
    )
    return head + done.written + done.read


def can_records(heard: Sequence[HeardFrame]) -> bytes:
    """CAN records of frames, without their senders."""
    if not heard:
        return b""
    if isinstance(heard, HeardSets):
        records = _blank_records(heard.set_identifiers, len(heard))
        records["end_ns"] = heard.ends_ns
        records["data"] = np.frombuffer(heard.data, "S8")
        return records.tobytes()
    frames, ends, _senders = zip(*heard, strict=True)
    identifiers, data, extended = zip(*frames, strict=True)
    if len(frames) >= WORTH_ARRAYS and set(map(len, data)) == {8}:
        return _full_records(ends, np.array(identifiers) | EXTENDED * np.array(extended), data)
    marked = [identifier | EXTENDED * long for identifier, long in zip(identifiers, extended, strict=True)]
    pack = CAN_HEAD.pack
    return b"".join([pack(end, i, len(d)) + d for end, i, d in zip(ends, marked, data, strict=True)])


@functools.lru_cache(16)
def _blank_records(identifiers: tuple[int, ...], count: int) -> Any:
    """Of sets with these identifiers: what is the same every time. Whoever gets it writes all the rest."""
    blank = np.empty(count, FULL_CAN_RECORD)
    blank["identifier"] = np.resize(identifiers, count)
    blank["n"] = 8
    return blank


def _full_records(ends_ns: ArrayLike, identifiers: ArrayLike, data: ArrayLike) -> bytes:
    """Records of frames of eight bytes, side by side."""
    records = np.empty(np.shape(ends_ns), FULL_CAN_RECORD)
    records["end_ns"] = ends_ns
    records["identifier"] = identifiers
    records["n"] = 8
    records["data"] = data
    return records.tobytes()


def spi_topic(bus: str) -> str:
    """Topic of an SPI bus."""
    return f"/spi/{bus}"


def i2c_topic(bus: str) -> str:
    """Topic of an I²C bus."""
    return f"/i2c/{bus}"


def uart_topic(port: str, direction: str) -> str:
    """Topic of one direction of a UART."""
    return f"/uart/{port}/{direction}"


def can_topic(bus: str) -> str:
    """Topic of a CAN bus."""
    return f"/can/{bus}"


def pin_topic(net: str) -> str:
    """Topic of a net."""
    return f"/pin/{net}"


MARK_TOPIC = "/recorded"


def _spi(topic: str, block: bytes, place: int) -> tuple[Traffic, int]:
    start_ns, duration_ns, n = SPI_HEAD.unpack_from(block, place)
    mosi = place + SPI_HEAD.size
    miso, end = mosi + n, mosi + 2 * n
    bus = topic.split("/")[2]
    return SpiTransaction(bus, start_ns, start_ns + duration_ns, block[mosi:miso], block[miso:end]), end


def _uart(topic: str, block: bytes, place: int) -> tuple[Traffic, int]:
    end_ns, n = UART_HEAD.unpack_from(block, place)
    data = place + UART_HEAD.size
    _, _, port, direction = topic.split("/")
    return UartChunk(port, direction, end_ns, block[data : data + n]), data + n


def _sent(topic: str, block: bytes, place: int) -> tuple[Traffic, int]:
    end_ns, baud, n = SENT_HEAD.unpack_from(block, place)
    data = place + SENT_HEAD.size
    _, _, port, direction = topic.split("/")
    return UartChunk(port, direction, end_ns, block[data : data + n], baud or None), data + n


def _can(topic: str, block: bytes, place: int) -> tuple[Traffic, int]:
    end_ns, identifier, n = CAN_HEAD.unpack_from(block, place)
    data = place + CAN_HEAD.size
    extended = bool(identifier & EXTENDED)
    bus = topic.split("/")[2]
    return CanMessage(bus, end_ns, identifier & ~EXTENDED, extended, block[data : data + n]), data + n


def _sent_can(topic: str, block: bytes, place: int) -> tuple[Traffic, int]:
    end_ns, identifier, n, s = SENT_CAN_HEAD.unpack_from(block, place)
    data = place + SENT_CAN_HEAD.size
    extended = bool(identifier & EXTENDED)
    bus, end = topic.split("/")[2], data + n + s
    sender = block[data + n : end].decode(errors="replace")
    return CanMessage(bus, end_ns, identifier & ~EXTENDED, extended, block[data : data + n], sender), end


def _i2c(topic: str, block: bytes, place: int) -> tuple[Traffic, int]:
    start_ns, end_ns, address, refusal, n, acknowledged, asked, m = I2C_HEAD.unpack_from(block, place)
    written = place + I2C_HEAD.size
    read, end = written + n, written + n + m
    if refusal >= len(REFUSALS):
        raise DamagedBlockError(f"{topic}: a record at byte {place} tells the unknown refusal {refusal}")
    sent, came = block[written:read], block[read:end]
    transfer = I2cTransfer(start_ns, end_ns, address, sent, acknowledged, asked, came, REFUSALS[refusal])
    return I2cTransaction(topic.split("/")[2], transfer), end


def _line(topic: str, block: bytes, place: int) -> tuple[Traffic, int]:
    told_ns, start_ns, first, baud, n = LINE_HEAD.unpack_from(block, place)
    data = place + LINE_HEAD.size
    port = topic.split("/")[2]
    if baud == 0:
        return LineCut(port, told_ns, start_ns), data + n
    form, baud = baud >> FORM_SHIFT, baud & LINE_BAUD
    if baud == 0:
        raise DamagedBlockError(f"{topic}: a record at byte {place} tells bytes at 0 baud")
    return LinePiece(port, told_ns, start_ns, first, baud, block[data : data + n], form), data + n


def _pin(topic: str, block: bytes, place: int) -> tuple[Traffic, int]:
    (change,) = PIN.unpack_from(block, place)
    return PinEdge(topic.split("/", 2)[2], change >> 1, bool(change & 1)), place + PIN.size


def _mark(_topic: str, block: bytes, place: int) -> tuple[Traffic, int]:
    return Mark(*MARK.unpack_from(block, place)), place + MARK.size


READERS = {
    "navtwin.SpiBlock": _spi,
    "navtwin.LineBlock": _line,
    "navtwin.SentBlock": _sent,
    "navtwin.UartBlock": _uart,
    "navtwin.I2cBlock": _i2c,
    "navtwin.CanFrameBlock": _sent_can,
    "navtwin.CanBlock": _can,
    "navtwin.PinBlock": _pin,
    "navtwin.Mark": _mark,
}
