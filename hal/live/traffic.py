"""What of a piece of serial traffic makes sense: how a rate, or a device, is recognised.

A recogniser tells how many of the bytes belong to whole units that it understands. Line noise and bytes
taken at a wrong rate hardly ever pass a checksum.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from functools import reduce
from operator import xor

Recogniser = Callable[[bytes], int]

NMEA_SENTENCE = re.compile(rb"\$([ -#%-)+-~]{5,100})\*([0-9A-Fa-f]{2})\r?\n")
TEXT_LINE = re.compile(rb"[ -~]{8,}\r?\n")
UBX_SYNC = b"\xb5\x62"
UBX_OVERHEAD = 8
UBX_LONGEST = 2048


def nmea(data: bytes) -> int:
    """Bytes in NMEA 0183 sentences whose checksum is right."""
    return sum(
        len(found[0])
        for found in NMEA_SENTENCE.finditer(data)
        if reduce(xor, found[1], 0) == int(found[2], 16)
    )


def ubx(data: bytes) -> int:
    """Bytes in UBX frames (b5 62, class, id, length, payload, Fletcher sum of 8 bits) that are right."""
    understood = 0
    at = data.find(UBX_SYNC)
    while at >= 0:
        length = int.from_bytes(data[at + 4 : at + 6], "little")
        frame = data[at : at + length + UBX_OVERHEAD]
        if length <= UBX_LONGEST and len(frame) == length + UBX_OVERHEAD and _fletcher_is_right(frame):
            understood += len(frame)
            at += len(frame) - 1
        at = data.find(UBX_SYNC, at + 1)
    return understood


def text(data: bytes) -> int:
    """Bytes in lines of at least eight readable characters."""
    return sum(len(found[0]) for found in TEXT_LINE.finditer(data))


KNOWN: Mapping[str, Recogniser] = {"NMEA": nmea, "UBX": ubx, "text": text}


def understood(data: bytes, recognisers: Mapping[str, Recogniser] = KNOWN) -> tuple[int, str]:
    """(bytes, of what) that make sense. NMEA and UBX share a line; text counts only without them."""
    counts = {name: recognise(data) for name, recognise in recognisers.items()}
    framed = {name: count for name, count in counts.items() if name != "text" and count}
    if framed:
        return sum(framed.values()), " and ".join(framed)
    return counts.get("text", 0), "text" if counts.get("text") else ""


def _fletcher_is_right(frame: bytes) -> bool:
    a = b = 0
    for byte in frame[2:-2]:
        a = (a + byte) & 0xFF
        b = (b + a) & 0xFF
    return frame[-2] == a and frame[-1] == b
