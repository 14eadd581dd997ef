"""A picture of a fixed size, also for terminals that show ASCII only; boxes whose lines know their room."""

from __future__ import annotations

from collections.abc import Callable

from rich.box import ROUNDED
from rich.console import Console, ConsoleOptions, RenderResult
from rich.layout import Layout
from rich.panel import Panel
from rich.segment import Segment
from rich.text import Text

Lines = Callable[[int, int], list[Text]]
"""Lines for a box of so many columns and rows."""
PLAIN_SIGNS = {"°": "d", "±": "~", "µ": "u", "²": "2", "·": ".", "•": "o", "…": ".", "×": "x"}
PLAIN_SIGNS |= dict.fromkeys("─━╸╺", "-") | dict.fromkeys("│", "|")
PLAIN_SIGNS |= dict(zip("↑↗→↘↓↙←↖", "^/>\\v/<\\", strict=True))


class Picture:
    """A layout, drawn exactly so large."""

    def __init__(self, layout: Layout, width: int, height: int) -> None:
        self._layout = layout
        self._size = width, height

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        lines = console.render_lines(self._layout, options.update_dimensions(*self._size))
        for line in lines:
            for text, style, control in line:
                yield Segment(text.translate(_AsPlain()) if options.ascii_only else text, style, control)
            yield Segment.line()


class _AsPlain(dict[int, str]):
    """What stands for a sign in ASCII; every sign keeps its width."""

    def __missing__(self, code: int) -> str:
        if code < 0x80:
            return chr(code)
        if 0x2800 < code <= 0x28FF:  # dots
            return "."
        otherwise = "+" if 0x2500 <= code < 0x2580 else "#" if 0x2580 <= code < 0x25A0 else "?"
        return PLAIN_SIGNS.get(chr(code), otherwise)


class _Filled:
    """Lines that are asked for once their room is known; cut there."""

    def __init__(self, lines: Lines) -> None:
        self._lines = lines

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        height = options.height or options.size.height
        for line in self._lines(max(options.max_width, 1), max(height, 1))[:height]:
            yield single(line)


def single(text: Text) -> Text:
    """One line, cut where the room ends."""
    text.no_wrap = True
    text.overflow = "crop"
    return text


def box(title: str, lines: Lines, size: int | None = None) -> Layout:
    """A frame with a title; `size`: so many rows or columns, else what is left."""
    filled = _Filled(lines)
    panel = Panel(
        filled, title=title, title_align="left", box=ROUNDED, border_style="bright_black", padding=0
    )
    return Layout(panel, size=size)
