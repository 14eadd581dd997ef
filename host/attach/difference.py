"""What two SOLUTION frames disagree in: field by field, to the last bit."""

from __future__ import annotations

import struct
from dataclasses import asdict, dataclass
from typing import Any

from firmware.link.frames import PAYLOADS, SOLUTION
from host.link.messages import Solution

SIGN = 1 << 31
FIRST_FLOAT = Solution._fields.index("height")


@dataclass(frozen=True, slots=True)
class Difference:
    """The board said one thing, the twin another."""

    board_s: float
    """On the board's clock."""
    what: str
    """"solution", "start", "state" or "configuration"."""
    field: str
    board: float | int | str
    twin: float | int | str
    ulp: int | None
    """How many float32 numbers lie between them; None: not numbers of that kind."""
    fields: int
    """How many fields differ."""

    def text(self) -> str:
        """One line."""
        ulp = "" if self.ulp is None else f", {self.ulp:,} ULP apart"
        more = f" (and {self.fields - 1} more fields)" if self.fields > 1 else ""
        values = f"board {self.board}, twin {self.twin}{ulp}{more}"
        return f"{self.what} at {self.board_s:.3f} s: {self.field}: {values}"

    def to_dict(self) -> dict[str, Any]:
        """For `--json`."""
        return asdict(self)


def solution_difference(board: bytes, twin: bytes) -> Difference | None:
    """The first field in which two payloads differ; None: equal in every bit."""
    if board == twin:
        return None
    layout = PAYLOADS[SOLUTION]
    if not len(board) == len(twin) == layout.size:
        return Difference(0.0, "solution", "length", len(board), len(twin), None, 1)
    ours, theirs = Solution(*layout.unpack(twin)), Solution(*layout.unpack(board))
    bits = [_bits(place, value) for place, value in enumerate(ours)]
    board_bits = [_bits(place, value) for place, value in enumerate(theirs)]
    different = [place for place, pair in enumerate(zip(board_bits, bits, strict=True)) if pair[0] != pair[1]]
    first = different[0]
    ulp = abs(_ordered(board_bits[first]) - _ordered(bits[first])) if first >= FIRST_FLOAT else None
    return Difference(
        theirs.time_us / 1e6,
        "solution",
        Solution._fields[first],
        theirs[first],
        ours[first],
        ulp,
        len(different),
    )


def _bits(place: int, value: float) -> int:
    if place < FIRST_FLOAT:
        return int(value)
    (bits,) = struct.unpack("<I", struct.pack("<f", value))
    return int(bits)


def _ordered(bits: int) -> int:
    """Float32 numbers in their order as integers in theirs."""
    return SIGN - bits if bits & SIGN else bits
