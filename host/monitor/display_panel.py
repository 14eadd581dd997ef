"""The board's own display: half a character for each pixel, or a dot, or its text: what there is room for."""

from __future__ import annotations

from rich.text import Text

from host.monitor.braille import ACROSS, DOWN, paint
from host.record.screens import Picture
from host.run.screen_text import LIT, text_lines

FRAME = 2
"""Columns, and rows, of a box's border."""
HALVES = 2
"""Pixels, one above the other, in a character of half blocks."""
BLOCKS = " ▄▀█"
"""By upper and lower pixel."""
STYLE = "bright_white"
TEXT_SIZE = (0, 10)


def box_size(picture: Picture, width: int, height: int) -> tuple[int, int]:
    """Columns and rows of the largest box for it that leaves something of `width` × `height`; TEXT_SIZE when
    there is room for its text only."""
    rows, columns = picture.shape
    for across, down in ((1, HALVES), (ACROSS, DOWN)):
        size = columns // across + FRAME, rows // down + FRAME
        if size[0] <= width and size[1] < height:
            return size
    return TEXT_SIZE


def display_lines(picture: Picture, width: int, height: int) -> list[Text]:
    """In `width` × `height` characters."""
    rows, columns = picture.shape
    lit = picture >= LIT
    if width >= columns and height * HALVES >= rows:
        signs = 2 * lit[0::2] + lit[1::2]
        return [Text("".join(BLOCKS[sign] for sign in row), STYLE, no_wrap=True) for row in signs.tolist()]
    if width * ACROSS >= columns and height * DOWN >= rows:
        return paint([(lit, STYLE)], {})
    return [Text(line, STYLE, no_wrap=True) for line in text_lines(picture)]
