"""Takes sentences out of the bytes from the host: "$", fields, "*", checksum, end of line.

Garbage, wrong checksums and sentences that break off are skipped; what is incomplete waits for more bytes.
"""

from __future__ import annotations

from typing import NamedTuple

from boards.chips.receivers.fields import xor_checksum

LONGEST_SENTENCE = 256
DOLLAR = 0x24


class Sentence(NamedTuple):
    """The comma fields of a sentence with a good checksum, the address first."""

    fields: tuple[str, ...]


class SentenceInput:
    """Bytes in, sentences out."""

    def __init__(self) -> None:
        self._buffer = bytearray()

    def feed(self, data: bytes) -> list[Sentence]:
        """The sentences that `data` completes."""
        buffer = self._buffer
        buffer += data
        found: list[Sentence] = []
        while (at := buffer.find(b"$")) >= 0:
            sentence, used = sentence_at(buffer, at)
            if sentence is not None:
                found.append(sentence)
            del buffer[: at + used]
            if not used:
                return found
        buffer.clear()
        return found


def sentence_at(buffer: bytearray, start: int) -> tuple[Sentence | None, int]:
    """The sentence that begins at `start`, and its length; (None, n) is none: the search goes on n bytes
    behind, (None, 0) is not complete yet."""
    for index in range(start + 1, min(len(buffer), start + LONGEST_SENTENCE)):
        byte = buffer[index]
        if byte in b"\r\n":
            return _checked(bytes(buffer[start + 1 : index])), index + 1 - start
        if byte == DOLLAR or not 0x20 <= byte < 0x7F:
            return None, index - start
    return None, 1 if len(buffer) - start >= LONGEST_SENTENCE else 0


def _checked(line: bytes) -> Sentence | None:
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
    return Sentence(tuple(body.decode("ascii").split(",")))
