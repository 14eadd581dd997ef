"""Takes messages out of the bytes from the host: UBX frames and NMEA sentences in any mixture.

Garbage, wrong checksums, frames of absurd length and sentences that break off are skipped; the search
goes on right behind the start that led astray, so that a good message inside is still found. What is
incomplete waits for more bytes.
"""

from __future__ import annotations

from typing import NamedTuple

from boards.chips.neo_m8n.fields import xor_checksum
from boards.chips.neo_m8n.ubx import SYNC, fletcher

LONGEST_PAYLOAD = 1024
"""A frame that announces more is taken for garbage."""
LONGEST_SENTENCE = 256
DOLLAR = 0x24
_HEADER = 6
_CHECK = 2


class UbxInput(NamedTuple):
    """A frame with a good checksum."""

    message_class: int
    message_id: int
    payload: bytes


class NmeaInput(NamedTuple):
    """The comma fields of a sentence with a good checksum, the address first."""

    fields: tuple[str, ...]


class InputParser:
    """Bytes in, messages out."""

    def __init__(self) -> None:
        self._buffer = bytearray()

    def reset(self) -> None:
        """Forget what is incomplete."""
        self._buffer.clear()

    def feed(self, data: bytes) -> list[UbxInput | NmeaInput]:
        """The messages that `data` completes."""
        buffer = self._buffer
        buffer += data
        messages: list[UbxInput | NmeaInput] = []
        position = 0
        while position < len(buffer):
            first = buffer[position]
            message: UbxInput | NmeaInput | None
            if first == SYNC[0]:
                message, used = self._frame(position)
            elif first == DOLLAR:
                message, used = self._sentence(position)
            else:
                position = _next_start(buffer, position + 1)
                continue
            if used == 0:
                break
            if message is not None:
                messages.append(message)
            position += used
        del buffer[:position]
        return messages

    def _frame(self, start: int) -> tuple[UbxInput | None, int]:
        """A frame at `start` and its length; (None, 1) is not a frame, (None, 0) not complete yet."""
        buffer = self._buffer
        if len(buffer) > start + 1 and buffer[start + 1] != SYNC[1]:
            return None, 1
        if len(buffer) < start + _HEADER:
            return None, 0
        length = buffer[start + 4] | buffer[start + 5] << 8
        if length > LONGEST_PAYLOAD:
            return None, 1
        end = start + _HEADER + length
        if len(buffer) < end + _CHECK:
            return None, 0
        if fletcher(buffer[start + 2 : end]) != buffer[end : end + _CHECK]:
            return None, 1
        payload = bytes(buffer[start + _HEADER : end])
        return UbxInput(buffer[start + 2], buffer[start + 3], payload), _HEADER + length + _CHECK

    def _sentence(self, start: int) -> tuple[NmeaInput | None, int]:
        """A sentence at `start` and its length, told as in `_frame`."""
        buffer = self._buffer
        for index in range(start + 1, min(len(buffer), start + LONGEST_SENTENCE)):
            byte = buffer[index]
            if byte in b"\r\n":
                return _checked(bytes(buffer[start + 1 : index])), index + 1 - start
            if byte == DOLLAR or not 0x20 <= byte < 0x7F:
                return None, index - start
        return None, 1 if len(buffer) - start >= LONGEST_SENTENCE else 0


def _next_start(buffer: bytearray, position: int) -> int:
    """Where the next message may begin."""
    starts = [found for found in (buffer.find(SYNC[:1], position), buffer.find(b"$", position)) if found >= 0]
    return min(starts, default=len(buffer))


def _checked(line: bytes) -> NmeaInput | None:
    """The fields between "$" and "*" when the two hex digits after it are right."""
    body, star, digits = line.rpartition(b"*")
    if not star or len(digits) != 2 or not digits.isalnum():
        return None
    try:
        wanted = int(digits, 16)
    except ValueError:
        return None
    if wanted != xor_checksum(body):
        return None
    return NmeaInput(tuple(body.decode("ascii").split(",")))
