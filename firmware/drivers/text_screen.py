"""Lines of text on an SSD1325: only what is new goes over the wire.

Eight lines of 21 characters, cells of 6 × 8 pixels, 24 bytes each; a marked line is dark on light. A screen
that is drawn anew whole takes 4 KB: 7.4 ms at 4.4 MHz. Characters that the font lacks are shown as `?`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from firmware.drivers import font_5x7 as font
from firmware.drivers.ssd1325 import HEIGHT, WIDTH, Ssd1325
from hal.cpu import Cpu

CELL_WIDTH: Final = font.WIDTH + 1
CELL_HEIGHT: Final = font.HEIGHT + 1
LINES: Final = HEIGHT // CELL_HEIGHT
CHARACTERS: Final = WIDTH // CELL_WIDTH
CELL_COLUMNS: Final = CELL_WIDTH // 2
"""Bytes of one row of a cell."""
LIGHT: Final = 0x0F
BLANK_LINE: Final = " " * CHARACTERS
MISSING: Final = "?"


def cell_rows(character: str, inverse: bool) -> tuple[bytes, ...]:
    """The rows of a cell, the topmost first."""
    columns = (*font.GLYPHS.get(character, font.GLYPHS[MISSING]), 0)
    rows = []
    for y in range(CELL_HEIGHT):
        levels = [LIGHT if (column >> y & 1) != inverse else 0 for column in columns]
        rows.append(bytes(levels[k] << 4 | levels[k + 1] for k in range(0, CELL_WIDTH, 2)))
    return tuple(rows)


class TextScreen:
    """Owns the display. `glyph_cycles`: what the processor takes for one character."""

    def __init__(self, display: Ssd1325, cpu: Cpu, glyph_cycles: int) -> None:
        self._display = display
        self._cpu = cpu
        self._glyph_cycles = glyph_cycles
        self._shown = [(BLANK_LINE, False)] * LINES
        """Text of each line and whether it is marked."""
        self._cells: dict[tuple[str, bool], tuple[bytes, ...]] = {}

    def start(self) -> None:
        """A dark screen."""
        self._display.start()
        self._shown = [(BLANK_LINE, False)] * LINES

    def stop(self) -> None:
        """Dark, whatever stands on it."""
        self._display.stop()

    def show(self, lines: Sequence[str], marked: int | None = None) -> None:
        """Have these lines on the screen, those beyond the last one empty; `marked`: the inverted one.

        What is too long or too many is cut off.
        """
        for line in range(LINES):
            text = lines[line] if line < len(lines) else ""
            wanted = text[:CHARACTERS].ljust(CHARACTERS), line == marked
            if wanted != self._shown[line]:
                self._draw(line, *self._span(line, *wanted))
                self._shown[line] = wanted

    def restore(self) -> None:
        """Set the display up again and draw everything once more: it may have lost both."""
        self._display.restore()
        for line, (text, inverse) in enumerate(self._shown):
            self._draw(line, 0, text, inverse)

    def _span(self, line: int, text: str, inverse: bool) -> tuple[int, str, bool]:
        """From the first to the last character that differs from what is shown."""
        before, was_inverse = self._shown[line]
        if was_inverse != inverse:
            return 0, text, inverse
        differs = [place for place in range(CHARACTERS) if text[place] != before[place]]
        return differs[0], text[differs[0] : differs[-1] + 1], inverse

    def _draw(self, line: int, place: int, text: str, inverse: bool) -> None:
        cells = [self._cell(character, inverse) for character in text]
        self._cpu.spend(self._glyph_cycles * len(cells))
        data = b"".join([cell[y] for y in range(CELL_HEIGHT) for cell in cells])
        columns = CELL_COLUMNS * len(cells)
        self._display.put(CELL_COLUMNS * place, CELL_HEIGHT * line, columns, data)

    def _cell(self, character: str, inverse: bool) -> tuple[bytes, ...]:
        key = character, inverse
        if key not in self._cells:
            self._cells[key] = cell_rows(character, inverse)
        return self._cells[key]
