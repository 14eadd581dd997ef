"""Numbers to text, fast: rows with a fixed number of decimals for each column, as CSV lines or JSON objects.

A run writes some thirty numbers ten times a virtual second. Python's own formatting takes 5–7 µs a row, a
tenth of the time of the whole emulation; this loop takes under 1 µs. A number that is not finite, or too
large for its decimals in 63 bits, becomes the empty mark. Ties are rounded away from zero.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from host.sim.compiled import entry, inner

LONGEST_NUMBER = 24


class RowText:
    """Rows (n, k) as text: piece 0, number 0, piece 1, number 1 … number k−1, piece k."""

    def __init__(self, pieces: Sequence[bytes], decimals: Sequence[int], empty: bytes) -> None:
        if len(pieces) != len(decimals) + 1:
            raise ValueError(
                f"{len(decimals)} columns need {len(decimals) + 1} pieces of text, not {len(pieces)}"
            )
        self._pieces = np.frombuffer(b"".join(pieces), dtype=np.uint8)
        self._piece_ends = np.cumsum([len(piece) for piece in pieces])
        self._decimals = np.array(decimals, dtype=np.int64)
        self._empty = np.frombuffer(empty, dtype=np.uint8)
        self._row_bound = len(self._pieces) + max(LONGEST_NUMBER, len(empty)) * len(decimals)

    @classmethod
    def csv(cls, decimals: Sequence[int]) -> RowText:
        """Lines of comma-separated values; nothing between the commas where there is no number."""
        return cls([b"", *[b","] * (len(decimals) - 1), b"\n"], decimals, b"")

    @classmethod
    def json(cls, names: Sequence[str], decimals: Sequence[int]) -> RowText:
        """Objects with the columns as keys; null where there is no number."""
        keys = [f',"{name}":'.encode() for name in names]
        return cls([b"{" + keys[0][1:], *keys[1:], b"}"], decimals, b"null")

    def text(self, rows: NDArray[np.float64]) -> bytes:
        """All rows, one after another."""
        out, ends = self._write(rows)
        return out[: ends[-1]].tobytes() if len(rows) else b""

    def block(self, rows: NDArray[np.float64]) -> tuple[NDArray[np.uint8], NDArray[np.int64]]:
        """All rows one after another, and where each one ends."""
        return self._write(rows)

    def texts(self, rows: NDArray[np.float64]) -> list[bytes]:
        """Each row by itself."""
        out, ends = self._write(rows)
        whole = out.tobytes()
        ends_list = ends.tolist()
        starts = [0, *ends_list[:-1]] if ends_list else []
        return [whole[start:end] for start, end in zip(starts, ends_list, strict=True)]

    def _write(self, rows: NDArray[np.float64]) -> tuple[NDArray[np.uint8], NDArray[np.int64]]:
        out = np.empty(self._row_bound * len(rows), dtype=np.uint8)
        ends = np.empty(len(rows), dtype=np.int64)
        flat = np.ascontiguousarray(rows, dtype=np.float64)
        _write_rows(flat, self._decimals, self._pieces, self._piece_ends, self._empty, out, ends)
        return out, ends


@inner
def _write_number(out, place, number, decimals):  # type: ignore[no-untyped-def]
    """Digits of an unsigned number with so many decimals from `place` on; returns the place behind them.
    Unsigned, a division by ten is a multiplication."""
    ten, zero = np.uint64(10), np.uint64(0)
    digits = 1
    rest = number // ten
    while rest > zero:
        digits += 1
        rest //= ten
    end = place + max(digits, decimals + 1) + (1 if decimals > 0 else 0)
    at = end - 1
    for _ in range(decimals):
        rest = number // ten
        out[at] = np.uint8(48) + np.uint8(number - rest * ten)
        number = rest
        at -= 1
    if decimals > 0:
        out[at] = 46
        at -= 1
    while at >= place:
        rest = number // ten
        out[at] = np.uint8(48) + np.uint8(number - rest * ten)
        number = rest
        at -= 1
    return end


@entry
def _write_rows(rows, decimals, pieces, piece_ends, empty, out, ends):  # type: ignore[no-untyped-def]
    """Compiled loop behind RowText."""
    scales = np.ones(decimals.shape[0])
    for j in range(decimals.shape[0]):
        for _ in range(decimals[j]):
            scales[j] *= 10.0
    place = 0
    for i in range(rows.shape[0]):
        taken = 0
        for j in range(rows.shape[1] + 1):
            while taken < piece_ends[j]:
                out[place] = pieces[taken]
                place += 1
                taken += 1
            if j == rows.shape[1]:
                taken = 0
                break
            value = rows[i, j]
            magnitude = abs(value) * scales[j] + 0.5
            if not magnitude < 9.0e18:
                for k in range(empty.shape[0]):
                    out[place] = empty[k]
                    place += 1
                continue
            number = np.uint64(np.int64(magnitude))
            if value < 0.0 and number > np.uint64(0):
                out[place] = 45
                place += 1
            place = _write_number(out, place, number, decimals[j])
        ends[i] = place
