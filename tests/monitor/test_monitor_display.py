"""A board's own display in the live view, and its keys under those of the terminal."""

from __future__ import annotations

import io

import numpy as np
from rich.console import Console

from host.monitor.board_source import BoardSource
from host.monitor.view import MonitorView
from host.record.result import RunRequest


def shown(view: MonitorView, width: int, height: int) -> list[str]:
    file = io.StringIO()
    Console(file=file, width=width, height=height, color_system=None).print(
        view.render(width, height), end=""
    )
    return file.getvalue().splitlines()


def dots_of(lines: list[str]) -> np.ndarray:
    """The lit dots of braille signs: (rows, columns)."""
    order = ((0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1), (3, 0), (3, 1))
    dots = np.zeros((4 * len(lines), 2 * max(map(len, lines))), bool)
    for row, line in enumerate(lines):
        for column, sign in enumerate(line):
            bits = ord(sign) - 0x2800 if sign != " " else 0
            for bit, (down, across) in enumerate(order):
                dots[4 * row + down, 2 * column + across] = bits >> bit & 1
    return dots


def test_the_display_is_shown_and_the_terminals_keys_are_the_boards() -> None:
    overrides = ("panel.mode=settings", "duration_s=30.0", 'segment=[{kind="rest",duration_s=30.0}]')
    source = BoardSource(RunRequest("gfsins", "static", overrides=overrides, capture=False), speed=0.0)
    view = MonitorView(source.title)
    try:
        assert "Enter" in source.hint

        def after(*keys: str) -> list[str]:
            for key in keys:
                source.press(key, view)
                source.press(key, view)  # it is held still: no second press
                source.pump(view, 60.0, source.now_s + 0.4)
            return shown(view, 58, 24)

        source.pump(view, 60.0, 0.001)
        source.pump(view, 60.0, 3.0)
        narrow = shown(view, 58, 24)
        assert narrow[2].startswith("│SETTINGS")
        assert narrow[3].startswith("│Status")
        wide = shown(view, 120, 34)
        assert len(wide) == 34
        picture = source._session.panel.picture()  # type: ignore[union-attr]
        assert np.array_equal(dots_of([line[1:65] for line in wide[2:18]]), picture > 7)
        assert "link and flags" in wide[1]
        large = shown(view, 130, 40)
        blocks = [[" ▄▀█".index(sign) for sign in line[1:129]] for line in large[2:34]]
        halves = np.array([[(sign >> 1, sign & 1) for sign in row] for row in blocks])
        assert np.array_equal(halves.transpose(0, 2, 1).reshape(64, 128), picture > 7)
        for width, height in ((20, 10), (65, 21), (66, 20), (67, 21), (131, 36), (129, 37), (300, 90)):
            assert len(shown(view, width, height)) == height
        assert after("down", "\n")[2].startswith("│Scale, offset")
        assert after("\x7f")[2].startswith("│SETTINGS")
        assert after("x", "left")[2].strip("│ ").split() == ["SETTINGS", "2/9"]
    finally:
        source.close()


def test_a_dark_display_leaves_the_panels_where_they_are() -> None:
    view = MonitorView("a board")
    usual = shown(view, 120, 40)
    view.display = np.full((64, 128), 15, np.uint8)
    assert shown(view, 120, 40) != usual
    view.display = None
    assert shown(view, 120, 40) == usual
