"""Reads the text on a display of 6 × 8 cells, by the shapes of its font: light on dark, or dark on light."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from firmware.drivers.font_5x7 import GLYPHS, HEIGHT, WIDTH

CELL_WIDTH, CELL_HEIGHT = WIDTH + 1, HEIGHT + 1
LIT = 8
UNKNOWN = "\N{REPLACEMENT CHARACTER}"


def _shape(columns: bytes) -> bytes:
    cell = np.zeros((CELL_HEIGHT, CELL_WIDTH), np.bool_)
    for x, column in enumerate(columns):
        for y in range(HEIGHT):
            cell[y, x] = column >> y & 1
    return cell.tobytes()


_CHARACTERS = {_shape(columns): character for character, columns in GLYPHS.items()}


def text_lines(picture: NDArray[np.uint8]) -> list[str]:
    """A text for each row of cells, without blanks at its end; a cell that is no character gives UNKNOWN.

    `picture` (rows, columns): grey levels 0 … 15.
    """
    lit = picture >= LIT
    rows, columns = lit.shape[0] // CELL_HEIGHT, lit.shape[1] // CELL_WIDTH
    cells = lit[: rows * CELL_HEIGHT, : columns * CELL_WIDTH].reshape(rows, CELL_HEIGHT, columns, CELL_WIDTH)
    cells = cells.transpose(0, 2, 1, 3)
    return ["".join(_character(cell) for cell in row).rstrip() for row in cells]


def _character(cell: NDArray[np.bool_]) -> str:
    """The gap below a character is dark, or light when it is inverted."""
    return _CHARACTERS.get((cell ^ cell[-1, -1]).tobytes(), UNKNOWN)
