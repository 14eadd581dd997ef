"""Writes a run's capture as it goes: an MCAP file of raw wire traffic in blocks and decoded topics in JSON.

What is recorded is handed to the file by `flush` as one LZ4 chunk. Whoever drives a capture calls it every
`FLUSH_EVERY_NS` of virtual time, so a process that is killed loses less than a second of virtual time;
everything before can be read with `host.capture.reader`. (Data are handed to the operating system, not
forced onto the disk: a power cut of the PC may lose more.) The file is written as `<name>.part` and renamed
when the run is over.

The bytes depend on the run alone: times are virtual, nothing in the file comes from a clock or names a
version of a library. The index at the end of an MCAP file is collected in memory, packed: about 1 MB for
each hour.
"""

from __future__ import annotations

import functools
import json
import struct
from array import array
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO, Protocol

import numpy as np
from numpy.typing import NDArray

from hal.emulated.can_bursts import HeardFrame
from hal.emulated.i2c import I2cObserver, I2cTransfer
from hal.emulated.spi import SpiTape
from host.capture.blocks import (
    CAN_SCHEMA,
    ENCODING,
    FIRST_TIME,
    FORM_SHIFT,
    LINE_HEAD,
    MARK,
    MARK_TOPIC,
    SCHEMAS,
    SENT_HEAD,
    SENT_SCHEMA,
    SPI_HEAD,
    can_topic,
    i2c_record,
    i2c_topic,
    pin_topic,
    spi_topic,
    uart_topic,
)
from host.capture.can_senders import with_senders
from host.capture.inertial_samples import IMU
from host.capture.location_fix import LOCATION_FIX, TOPICS
from host.capture.location_fix import schema as location_fix_schema
from host.capture.mcap_file import McapFile
from host.capture.row_messages import RowMessages, event_message
from host.capture.sensor_traffic import DECODERS, SensorTraffic
from host.capture.topics import (
    CLOCK,
    CONTROL,
    EVENTS,
    IMU_SCHEMA,
    TABLES,
    clock_schema,
    control_schema,
    event_schema,
    table_schema,
)
from host.record.tables import Table

CAPTURE_FORMAT = "navtwin-capture-4"
"""Of the raw topics; 4 added the rate at which a UART sends, and when clocks began to count."""
FORMAT_3, FORMAT_2 = "navtwin-capture-3", "navtwin-capture-2"
"""3 had added I²C buses and the senders of CAN frames, 2 pins, marks and exact times of lines into boards."""
FLUSH_EVERY_NS = 900_000_000
ROOM = 1 << 16
"""Bytes that the file gathers: most chunks go to the system at once."""
IMU_TEXT = "{" + ",".join(f'"{name}":%.{n}f' for name, n in zip(IMU.columns, IMU.decimals, strict=True)) + "}"
"""A row of IMU; all of it are numbers."""

Bytes = bytes | bytearray
SpiRecorder = Callable[[int, int, Bytes, Bytes], None]


class UartRecorder(Protocol):
    """For one direction of a UART."""

    def __call__(self, end_ns: int, data: bytes, baud: int = 0) -> None:
        """Bytes of which the last one ended at `end_ns`; `baud` 0: not known."""
        ...


CanRecorder = Callable[[bytes, Sequence[HeardFrame]], None]
"""(records without senders, the frames they are of)."""
LineRecorder = Callable[..., None]


class CaptureWriter:
    """One capture file. Recorders for the wires are asked for once and then called for each transfer."""

    def __init__(self, path: Path, manifest: Mapping[str, Any]) -> None:
        self.path = path
        self.part = path.with_name(path.name + ".part")
        self._file: BinaryIO = self.part.open("wb", buffering=ROOM)
        self._writer = McapFile(self._file, profile="navtwin", library="navtwin")
        text = json.dumps(manifest, indent=1, sort_keys=True).encode()
        self._writer.add_attachment("manifest.json", "application/json", text)
        self._writer.add_metadata("capture", {"format": CAPTURE_FORMAT})
        self._file.flush()
        self._schemas: dict[str, int] = {}
        self._blocks: list[tuple[int, bytearray]] = []
        self._tapes: list[tuple[int, list[int]]] = []
        self._spi: dict[str, tuple[bytearray, list[bytes], list[bytes]]] = {}
        """Of each chip select the block, the records that will be in it, and MOSI of the transactions of two
        bytes: register accesses."""
        self._shown: list[tuple[int, str, SensorTraffic]] = []
        self._marks = self._raw_channel(MARK_TOPIC, "navtwin.Mark")
        self._row_messages = RowMessages()
        self._row_channels = {topic: self._table_channel(topic, *table) for topic, table in TABLES.items()}
        self._row_channels |= {place: self._fix_channel(place) for place in TOPICS.values()}
        self._control: int | None = None
        """Only of a run that is served."""
        self._events = self._channel(EVENTS[0], "json", EVENTS[1], "jsonschema", event_schema())
        self._clocks = self._channel(CLOCK[0], "json", CLOCK[1], "jsonschema", clock_schema())

    # -- raw traffic -------------------------------------------------------------------------------

    def spi_recorder(self, bus: str) -> SpiRecorder:
        """`record(start_ns, end_ns, mosi, miso)` for one SPI bus: the observer of a bus, made for speed."""
        tape = SpiTape(_spi_record)
        self._spi[bus] = self._block(spi_topic(bus), "navtwin.SpiBlock"), tape.records, tape.pairs
        return tape

    def i2c_recorder(self, bus: str) -> I2cObserver:
        """`record(transfer)` for one I²C bus."""
        block = self._block(i2c_topic(bus), "navtwin.I2cBlock")

        def record(done: I2cTransfer) -> None:
            nonlocal block
            block += i2c_record(done)

        return record

    def uart_recorder(self, port: str, direction: str) -> UartRecorder:
        """For one direction ("rx", "tx") of a UART."""
        block = self._block(uart_topic(port, direction), SENT_SCHEMA)

        def record(end_ns: int, data: bytes, baud: int = 0) -> None:
            nonlocal block
            block += SENT_HEAD.pack(end_ns, baud, len(data))
            block += data

        return record

    def line_recorder(self, port: str) -> LineRecorder:
        """`record(told_ns, start_ns, first, baud, data, form)` for the line into a UART (`blocks`)."""
        block = self._block(uart_topic(port, "rx"), "navtwin.LineBlock")

        def record(told_ns: int, start_ns: int, first: int, baud: int, data: bytes, form: int = 0) -> None:
            nonlocal block
            block += LINE_HEAD.pack(told_ns, start_ns, first, baud | form << FORM_SHIFT, len(data))
            block += data

        return record

    def pin_tape(self, net: str) -> list[int]:
        """A list for changes of a net's level, 2·time + level each; whoever drives the net appends to it."""
        tape: list[int] = []
        self._tapes.append((self._raw_channel(pin_topic(net), "navtwin.PinBlock"), tape))
        return tape

    def can_recorder(self, bus: str) -> CanRecorder:
        """`record(records, heard)`: frames of one CAN bus, and the same as `blocks.can_records`."""
        block = self._block(can_topic(bus), CAN_SCHEMA)

        def record(records: bytes, heard: Sequence[HeardFrame]) -> None:
            nonlocal block
            block += with_senders(records, heard)

        return record

    # -- what was decoded --------------------------------------------------------------------------

    def rows(self, topic: str, rows: NDArray[np.float64]) -> None:
        """Rows of a table of `host.record.tables` ("/solution", "/gnss", …); column 0 is the time in s."""
        for place, times_ns, texts in self._row_messages.of(topic, rows):
            self._writer.add_texts(self._row_channels[place], times_ns, texts)

    def show_sensor(self, refdes: str, part: str, bus: str) -> None:
        """Show samples of an inertial sensor under /imu/<refdes>, when its part is known; see `glimpse`."""
        if part in DECODERS and bus in self._spi:
            channel = self._table_channel(f"/imu/{refdes}", IMU_SCHEMA, IMU)
            self._shown.append((channel, bus, DECODERS[part]()))

    def glimpse(self) -> None:
        """Show the last sample of each sensor since the last flush."""
        for channel, bus, traffic in self._shown:
            block, records, pairs = self._spi[bus]
            block += b"".join(records)
            records.clear()
            row = traffic.glimpse(block, pairs)
            if row is not None:
                t_ns = round(row[0] * 1e9)
                self._writer.add_message(channel, t_ns, (IMU_TEXT % row).encode())

    def event(self, t_ns: int, source: str, text: str) -> None:
        """Something worth telling."""
        self._writer.add_message(self._events, t_ns, event_message(t_ns, source, text))

    def clock(self, reset_ns: int, processor: str, rate_ppb: int) -> None:
        """From `reset_ns` on a processor's clock counts anew, too fast by `rate_ppb`."""
        entry = {"t_s": reset_ns / 1e9, "reset_ns": reset_ns, "processor": processor, "rate_ppb": rate_ppb}
        text = json.dumps(entry, separators=(",", ":")).encode()
        self._writer.add_message(self._clocks, reset_ns, text)

    def control(self, t_ns: int, command: str, details: Mapping[str, Any]) -> None:
        """Something was done to the board from outside."""
        if self._control is None:
            self._control = self._channel(CONTROL[0], "json", CONTROL[1], "jsonschema", control_schema())
        entry = {"t_s": t_ns / 1e9, "time_ns": t_ns, "command": command, **details}
        self._writer.add_message(self._control, t_ns, json.dumps(entry, separators=(",", ":")).encode())

    # -- the file ----------------------------------------------------------------------------------

    def flush(self, now_ns: int | None = None) -> None:
        """Hand what was recorded to the file; `now_ns`: all that happened before has been recorded."""
        for channel, tape in self._tapes:
            if tape:
                t_ns = tape[0] >> 1
                self._writer.add_message(channel, t_ns, array("q", tape).tobytes())
                tape.clear()
        for block, records, pairs in self._spi.values():
            block += b"".join(records)
            records.clear()
            pairs.clear()
        for channel, block in self._blocks:
            if block:
                (t_ns,) = FIRST_TIME.unpack_from(block)
                self._writer.add_message(channel, t_ns, block)
                block.clear()
        if now_ns is not None:
            self._writer.add_message(self._marks, now_ns, MARK.pack(now_ns))
        self._writer.flush()

    def close(self, summary: Mapping[str, str] | None = None) -> None:
        """End the file with a metadata record `end`, behind all that was recorded, and give it its name."""
        self.flush()
        self._writer.add_metadata("end", dict(summary or {}))
        self.abandon()
        self.part.replace(self.path)

    def abandon(self) -> None:
        """Write out what there is and leave it under its provisional name: the run did not reach its end."""
        if self._file.closed:
            return
        self.flush()
        self._writer.finish()
        self._file.close()

    def _block(self, topic: str, schema: str) -> bytearray:
        block = bytearray()
        self._blocks.append((self._raw_channel(topic, schema), block))
        return block

    def _raw_channel(self, topic: str, schema: str) -> int:
        return self._channel(topic, ENCODING, schema, ENCODING, SCHEMAS[schema].encode())

    def _fix_channel(self, topic: str) -> int:
        return self._channel(topic, "json", LOCATION_FIX, "jsonschema", location_fix_schema())

    def _table_channel(self, topic: str, schema: str, table: Table) -> int:
        return self._channel(topic, "json", schema, "jsonschema", table_schema(schema, table))

    def _channel(
        self, topic: str, encoding: str, schema: str, schema_encoding: str, definition: bytes
    ) -> int:
        if schema not in self._schemas:
            self._schemas[schema] = self._writer.register_schema(schema, schema_encoding, definition)
        return self._writer.register_channel(topic, encoding, self._schemas[schema])


@functools.cache
def _spi_record(length: int) -> Callable[..., bytes]:
    """Packs the record of a transaction of `length` bytes."""
    return struct.Struct(f"{SPI_HEAD.format}{length}s{length}s").pack
