"""A receiver's log cut into UBX frames, NMEA sentences, RTCM 3 frames, and bytes that are none of them.

    UBX     B5 62 | class id | length u16 | payload | Fletcher-8 over class … payload
    NMEA    $ … * XOR of what stands between, two hex digits | CR LF
    RTCM    D3 | 6 zero bits, 10 bits length | payload | CRC-24Q

Every byte of the file is in one piece, in order. A frame whose check fails is told as such and given up byte
by byte, so that nothing behind a damaged length is lost.
"""

from __future__ import annotations

import functools
import operator
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import Enum, auto
from itertools import accumulate
from pathlib import Path

import crcmod

BLOCK = 1 << 16
LONGEST_UBX = 1 << 13
LONGEST_SENTENCE = 1 << 10
START = re.compile(rb"\xb5\x62|\xd3|\$|(?<![^\n])#")
COMMENT = re.compile(rb"#[ -~\r\t]*\n")
SENTENCE = re.compile(rb"\$[ -#%-~]*\r?\n")
TALKER = re.compile(rb"\$[A-Z]{2}")
NOT_OF_A_SENTENCE = re.compile(rb"[^ -#%-~\r]|\r[^\n]")
CRC24Q = crcmod.mkCrcFun(0x1864CFB, initCrc=0, rev=False, xorOut=0)


class Piece(Enum):
    """What a piece of a log is."""

    UBX = auto()
    NMEA = auto()
    RTCM = auto()
    OTHER = auto()
    DAMAGED = auto()
    """Begins like a frame or a sentence, but its check fails or it has none."""
    CUT_OFF = auto()
    """A frame or sentence that the file ends in."""


@dataclass(frozen=True, slots=True)
class Frame:
    """One piece, where it begins, and in which line."""

    piece: Piece
    data: bytes
    offset: int
    line: int


def frames(path: Path, meter: Callable[[int], None]) -> Iterator[Frame]:
    """All pieces of a log."""
    offset, line = 0, 1
    for piece, data in _pieces(path, meter):
        yield Frame(piece, data, offset, line)
        offset += len(data)
        line += data.count(b"\n")


def _pieces(path: Path, meter: Callable[[int], None]) -> Iterator[tuple[Piece, bytes]]:
    with path.open("rb") as file:
        buffer = b""
        while True:
            block = file.read(BLOCK)
            meter(len(block))
            buffer += block
            place = 0
            while place < len(buffer):
                found = START.search(buffer, place)
                begin = len(buffer) if found is None else found.start()
                if found is None and block and buffer.endswith(b"\xb5"):
                    begin -= 1
                if begin > place:
                    yield Piece.OTHER, buffer[place:begin]
                if found is None:
                    place = begin
                    break
                piece, end = _frame(buffer, begin, is_last=not block)
                if piece is None:
                    place = begin
                    break
                yield piece, buffer[begin:end]
                place = end
            buffer = buffer[place:]
            if not block:
                if buffer:
                    yield Piece.OTHER, buffer
                return


def _frame(buffer: bytes, begin: int, is_last: bool) -> tuple[Piece | None, int]:
    """(what begins there, where it ends); None: more bytes are needed to tell."""
    first = buffer[begin]
    if first == ord("#"):
        return Piece.OTHER, found.end() if (found := COMMENT.match(buffer, begin)) else begin + 1
    whole = _ubx if first == 0xB5 else _rtcm if first == 0xD3 else _sentence
    piece, end = whole(buffer, begin)
    if piece is None and is_last:
        if first == ord("$") and _sums(buffer[begin:]):
            return Piece.NMEA, len(buffer)
        return (Piece.OTHER, begin + 1) if first == 0xD3 else (Piece.CUT_OFF, _next_start(buffer, begin))
    return piece, end


def _next_start(buffer: bytes, begin: int) -> int:
    found = START.search(buffer, begin + 1)
    return len(buffer) if found is None else found.start()


def _ubx(buffer: bytes, begin: int) -> tuple[Piece | None, int]:
    if len(buffer) < begin + 6:
        return None, begin
    end = begin + 8 + int.from_bytes(buffer[begin + 4 : begin + 6], "little")
    if end - begin > LONGEST_UBX:
        return Piece.DAMAGED, begin + 2
    if len(buffer) < end:
        return None, begin
    body = buffer[begin + 2 : end - 2]
    sums = bytes((sum(body) & 0xFF, sum(accumulate(body)) & 0xFF))
    return (Piece.UBX, end) if sums == buffer[end - 2 : end] else (Piece.DAMAGED, begin + 2)


def _sentence(buffer: bytes, begin: int) -> tuple[Piece | None, int]:
    match = SENTENCE.match(buffer, begin)
    if match is None:
        stop = NOT_OF_A_SENTENCE.search(buffer, begin + 1)
        if stop is None:
            if len(buffer) - begin > LONGEST_SENTENCE:
                return Piece.OTHER, begin + 1
            return None, begin
        if TALKER.match(buffer, begin):
            return Piece.DAMAGED, stop.start()
        return Piece.OTHER, begin + 1
    return (Piece.NMEA if _sums(match[0]) else Piece.DAMAGED), match.end()


def _sums(sentence: bytes) -> bool:
    body, star, told = sentence[1:].strip().partition(b"*")
    return bool(star) and b"%02X" % functools.reduce(operator.xor, body, 0) == told.upper()


def _rtcm(buffer: bytes, begin: int) -> tuple[Piece | None, int]:
    if len(buffer) < begin + 3:
        return None, begin
    if buffer[begin + 1] & 0xFC:
        return Piece.OTHER, begin + 1
    end = begin + 6 + ((buffer[begin + 1] & 0x03) << 8 | buffer[begin + 2])
    if len(buffer) < end:
        return None, begin
    is_whole = CRC24Q(buffer[begin : end - 3]) == int.from_bytes(buffer[end - 3 : end], "big")
    return (Piece.RTCM, end) if is_whole else (Piece.OTHER, begin + 1)
