"""Records of a capture as rows of tables: decoded topics as they are, raw ones with their bytes in hex."""

from __future__ import annotations

import json
from typing import Any

from host.capture.blocks import (
    CanMessage,
    I2cTransaction,
    LineCut,
    LinePiece,
    Mark,
    PinEdge,
    SpiTransaction,
    Traffic,
    UartChunk,
    can_topic,
    i2c_topic,
    pin_topic,
    spi_topic,
    uart_topic,
)
from host.capture.reader import Decoded
from host.capture.topics import CONTROL

NS = 1_000_000_000
Row = dict[str, Any]


def row_of(record: Traffic | Decoded) -> tuple[str, Row] | None:
    """(topic, row) of one record; None for what is no row of any table."""
    match record:
        case Decoded(topic=topic) if topic == CONTROL[0]:
            return topic, _control_row(record.value)
        case Decoded():
            return record.topic, _flat(record.value)
        case SpiTransaction():
            row: Row = {"t_s": record.start_ns / NS, "duration_s": (record.end_ns - record.start_ns) / NS}
            return spi_topic(record.bus), {**row, "mosi": record.mosi.hex(), "miso": record.miso.hex()}
        case I2cTransaction():
            return i2c_topic(record.bus), _i2c_row(record)
        case LinePiece():
            row = {"t_s": record.end_ns / NS, "baud": record.baud, "data": record.data.hex()}
            return uart_topic(record.port, "rx"), row
        case UartChunk():
            row = {"t_s": record.end_ns / NS, "baud": record.baud, "data": record.data.hex()}
            return uart_topic(record.port, record.direction), row
        case CanMessage():
            row = {"t_s": record.end_ns / NS, "identifier": record.identifier, "extended": record.extended}
            return can_topic(record.bus), {**row, "data": record.data.hex(), "sender": record.sender}
        case PinEdge():
            return pin_topic(record.net), {"t_s": record.time_ns / NS, "level": int(record.level)}
        case LineCut() | Mark():
            return None


def _i2c_row(record: I2cTransaction) -> Row:
    done = record.transfer
    return {
        "t_s": done.start_ns / NS,
        "duration_s": (done.end_ns - done.start_ns) / NS,
        "address": done.address,
        "written": done.written.hex(),
        "acknowledged": done.acknowledged,
        "asked": done.asked,
        "read": done.read.hex(),
        "refusal": None if done.refusal is None else done.refusal.name.lower(),
    }


def _control_row(value: Row) -> Row:
    """What belongs to a command is another thing for each: as JSON in one column."""
    own = ("t_s", "time_ns", "command")
    more = {name: one for name, one in value.items() if name not in own}
    return {"t_s": value.get("t_s"), "command": value.get("command"), "arguments": json.dumps(more)}


def _flat(value: Row) -> Row:
    """Tables and lists inside a message as columns of their own: timestamp_sec, position_covariance_0, …"""
    if not any(isinstance(one, dict | list) for one in value.values()):
        return value
    flat: Row = {}
    for name, one in value.items():
        inner = one.items() if isinstance(one, dict) else enumerate(one) if isinstance(one, list) else None
        flat |= {name: one} if inner is None else {f"{name}_{key}": part for key, part in inner}
    return flat
