"""Frames of the monitor: COBS( type u8, sequence u8, payload, CRC-32 ) 0x00. See firmware/target/frames.h."""

from __future__ import annotations

import struct
import zlib

END = b"\0"
LONGEST_RUN = 254


def encode(kind: int, sequence: int, payload: bytes) -> bytes:
    """The bytes of one frame on the line, with an end before it: what came until then is over."""
    body = bytes((kind, sequence)) + payload
    return END + _stuffed(body + struct.pack("<I", zlib.crc32(body))) + END


def decode(line: bytes) -> tuple[int, int, bytes] | None:
    """(type, sequence, payload) of what stood between two ends; None when it is damaged."""
    body = _unstuffed(line)
    if body is None or len(body) < 6 or zlib.crc32(body[:-4]) != struct.unpack("<I", body[-4:])[0]:
        return None
    return body[0], body[1], body[2:-4]


def _stuffed(body: bytes) -> bytes:
    parts = []
    for run in body.split(END):
        while len(run) >= LONGEST_RUN:
            parts.append(b"\xff" + run[:LONGEST_RUN])
            run = run[LONGEST_RUN:]
        parts.append(bytes((len(run) + 1,)) + run)
    return b"".join(parts)


def _unstuffed(line: bytes) -> bytes | None:
    parts, at = [], 0
    while at < len(line):
        code = line[at]
        run = line[at + 1 : at + code]
        at += code
        if code == 0 or len(run) != code - 1:
            return None
        parts.append(run if code == LONGEST_RUN + 1 or at == len(line) else run + END)
    return b"".join(parts)
