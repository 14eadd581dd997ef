"""What goes between the processors while something is calibrated: a request by SPI packet, its answer by I²C.

    request, 48 words as in acquisition (`firmware.nav.gyro_free.packet`), of another kind:
        0 sync   1 kind 0x4753   2 number   3 what   4 procedure   5 index   6 how many values
        7 …      values, signed, 32 bits each, high word first        47 CRC
    answer, what the DSP writes to the FPGA:
        ANSWER, number (16 bits), result, how many values, values (float32), CRC (16 bits), high byte first

The FPGA asks, and asks again until the answer of that number is there; the DSP does nothing by itself.
Whatever is lost or spoilt on either way costs one repetition.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from struct import Struct
from typing import Final

from firmware.apps.gfsins.commands import SUM, check_sum
from firmware.nav.gyro_free import packet as pk

KIND: Final = 0x4753
ANSWER: Final = 0x20
NUMBER, WHAT, PROCEDURE, INDEX, COUNT, VALUES = 2, 3, 4, 5, 6, 7
MOST_VALUES: Final = 20
POSITION_VALUES: Final = 15
"""Of every position."""
MOST_ANSWERED: Final = 12
LARGEST: Final = (1 << 31) - 1
WORDS: Final = Struct(f">{pk.WORDS}H")
HEAD: Final = Struct(">BHBB")
SYNC: Final = int(pk.SYNC_WORD)


class What(IntEnum):
    """What is asked for."""

    BEGIN = 1
    """A procedure, from its first position; values: latitude 1e-7°, height mm, whether both are known."""
    POSITION = 2
    """Take what was collected in position `index`."""
    SOLVE = 3
    GIVE = 4
    """Part `index` of the result."""


class Result(IntEnum):
    """How it went."""

    DONE = 0
    UNKNOWN = 1
    """The request does not follow from those before: the DSP has begun anew."""
    NOT_TOLD = 2
    """The positions do not tell all unknowns."""
    IMPLAUSIBLE = 3


@dataclass(frozen=True, slots=True)
class Request:
    """One request."""

    number: int
    what: What
    procedure: int
    index: int = 0
    values: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class Answer:
    """One answer."""

    number: int
    result: Result
    values: tuple[float, ...] = ()


def pack_request(request: Request) -> bytes:
    """The packet. Values beyond 32 bits are the largest."""
    values = [max(-LARGEST, min(LARGEST, value)) & 0xFFFFFFFF for value in request.values[:MOST_VALUES]]
    head = (SYNC, KIND, request.number, request.what, request.procedure, request.index, len(values))
    words = [*head, *(half for value in values for half in (value >> 16, value & 0xFFFF))]
    words += [0] * (pk.WORDS - len(words))
    data = WORDS.pack(*words)
    return data[: -SUM.size] + SUM.pack(check_sum(data[: -SUM.size]))


def open_request(data: bytes) -> Request | None:
    """None: it is no request, or it is spoilt."""
    words = WORDS.unpack(data)
    count = words[COUNT]
    if words[0] != SYNC or words[1] != KIND or words[pk.CRC] != check_sum(data[: -SUM.size]):
        return None
    if words[WHAT] not in set(What) or count > MOST_VALUES:
        return None
    halves = words[VALUES : VALUES + 2 * count]
    values = tuple(_signed(high << 16 | low) for high, low in zip(halves[::2], halves[1::2], strict=True))
    return Request(words[NUMBER], What(words[WHAT]), words[PROCEDURE], words[INDEX], values)


def pack_answer(answer: Answer) -> bytes:
    """The bytes to be written."""
    count = len(answer.values)
    data = HEAD.pack(ANSWER, answer.number, answer.result, count)
    data += Struct(f">{count}f").pack(*answer.values)
    return data + SUM.pack(check_sum(data))


def open_answer(data: bytes) -> Answer | None:
    """None: it is no answer, or it is spoilt."""
    if len(data) < HEAD.size + SUM.size or SUM.unpack(data[-SUM.size :])[0] != check_sum(data[: -SUM.size]):
        return None
    kind, number, result, count = HEAD.unpack_from(data)
    told = data[HEAD.size : -SUM.size]
    if kind != ANSWER or result not in set(Result) or len(told) != 4 * count:
        return None
    return Answer(number, Result(result), Struct(f">{count}f").unpack(told))


def _signed(value: int) -> int:
    return value - (1 << 32) if value & 0x80000000 else value
