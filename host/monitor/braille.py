"""A canvas of dots, two across and four down in each character; every layer has its own colour.

Dots are about square in a terminal. Where layers meet in one character, it takes the colour of the last one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from rich.text import Text

ACROSS = 2
DOWN = 4
BITS = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]])
"""Of U+2800: dot by row and column."""
EMPTY = 0x2800

Mask = NDArray[np.bool_]


def blank(width: int, height: int) -> Mask:
    """Dots of a canvas of `width` × `height` characters: (rows, columns), all off."""
    return np.zeros((height * DOWN, width * ACROSS), bool)


def line(dots: Mask, start: tuple[int, int], end: tuple[int, int]) -> None:
    """Set the dots from `start` to `end`, each (row, column); what lies outside is left out."""
    steps = max(abs(end[0] - start[0]), abs(end[1] - start[1]), 1)
    rows = np.rint(np.linspace(start[0], end[0], steps + 1)).astype(int)
    columns = np.rint(np.linspace(start[1], end[1], steps + 1)).astype(int)
    inside = (rows >= 0) & (rows < dots.shape[0]) & (columns >= 0) & (columns < dots.shape[1])
    dots[rows[inside], columns[inside]] = True


def characters(dots: Mask) -> NDArray[np.int64]:
    """Code points of the characters, (height, width); EMPTY where no dot is set."""
    rows, columns = dots.shape
    cells = dots.reshape(rows // DOWN, DOWN, columns // ACROSS, ACROSS)
    codes: NDArray[np.int64] = EMPTY + np.einsum("rdca,da->rc", cells, BITS)
    return codes


def paint(layers: list[tuple[Mask, str]], marks: dict[tuple[int, int], tuple[str, str]]) -> list[Text]:
    """Lines of text from layers (dots, style) and single characters at (row, column): (character, style)."""
    codes = characters(np.logical_or.reduce([dots for dots, _ in layers]))
    owner = np.full(codes.shape, -1)
    for number, (dots, _) in enumerate(layers):
        owner[characters(dots) != EMPTY] = number
    styles = [style for _, style in layers] + [""]
    lines = []
    for row, (line_codes, owners) in enumerate(zip(codes.tolist(), owner.tolist(), strict=True)):
        text = Text(no_wrap=True)
        begin = 0
        signs = [chr(code) if code != EMPTY else " " for code in line_codes]
        for column in range(1, len(signs) + 1):
            if column == len(signs) or owners[column] != owners[begin]:
                text.append("".join(signs[begin:column]), styles[owners[begin]])
                begin = column
        for (mark_row, column), (sign, style) in marks.items():
            if mark_row == row and 0 <= column < len(signs):
                text = Text.assemble(text[:column], (sign, style), text[column + 1 :], no_wrap=True)
        lines.append(text)
    return lines
