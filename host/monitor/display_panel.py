"""The board's own display: every pixel a dot, or its text where there is no room for the dots."""

from __future__ import annotations

from rich.text import Text

from host.monitor.braille import ACROSS, DOWN, paint
from host.record.screens import Picture
from host.run.screen_text import LIT, text_lines

FRAME = 2
"""Columns of a box's border."""


def columns_of(picture: Picture) -> int:
    """How wide a box with all its dots is."""
    return picture.shape[1] // ACROSS + FRAME


def display_lines(picture: Picture, width: int, height: int) -> list[Text]:
    """In `width` × `height` characters."""
    rows, columns = picture.shape
    if width * ACROSS >= columns and height * DOWN >= rows:
        return paint([(picture >= LIT, "bright_white")], {})
    return [Text(line, "bright_white", no_wrap=True) for line in text_lines(picture)]
