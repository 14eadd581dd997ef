"""Text on the display: what stands there, read by eye and by machine, and what goes over the wire for it."""

from __future__ import annotations

import string

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as some
from test_ssd1325_driver import Desk

from firmware.drivers.font_5x7 import CHARACTERS
from firmware.drivers.text_screen import TextScreen
from host.run.screen_text import UNKNOWN, text_lines


def screen() -> tuple[Desk, TextScreen]:
    desk = Desk()
    shown = TextScreen(desk.driver, desk.cpu, 100)
    shown.start()
    return desk, shown


def test_letters_look_like_letters() -> None:
    desk, shown = screen()
    shown.show(["H1", "", "iA"])
    rows = desk.model.as_text().splitlines()
    assert [row[:12] for row in rows[:8]] == [
        "#...#...#...",
        "#...#..##...",
        "#...#...#...",
        "#####...#...",
        "#...#...#...",
        "#...#...#...",
        "#...#..###..",
        "............",
    ]
    assert [row[:12] for row in rows[16:24]] == [
        "..#....###..",
        "......#...#.",
        ".##...#...#.",
        "..#...#...#.",
        "..#...#####.",
        "..#...#...#.",
        ".###..#...#.",
        "............",
    ]
    assert set("".join(row[12:] for row in rows)) == {"."}


LINES = some.lists(some.text(some.sampled_from(CHARACTERS), max_size=25), max_size=10)
MARKED = some.none() | some.integers(0, 7)


@settings(deadline=None)
@given(LINES, MARKED, LINES, MARKED)
def test_what_is_drawn_anew_is_what_differs(
    before: list[str], marked_before: int | None, after: list[str], marked: int | None
) -> None:
    desk, shown = screen()
    shown.show(before, marked_before)
    shown.show(after, marked)
    expected = [line[:21].rstrip() for line in after[:8]]
    assert text_lines(desk.model.picture()) == expected + [""] * (8 - len(expected))
    fresh_desk, fresh = screen()
    fresh.show(after, marked)
    assert np.array_equal(desk.model.picture(), fresh_desk.model.picture())
    desk.model.power(False)
    desk.model.power(True)
    shown.restore()
    assert np.array_equal(desk.model.picture(), fresh_desk.model.picture())


def test_only_what_is_new_goes_over_the_wire() -> None:
    desk, shown = screen()
    shown.show(["progress  10 %"])
    before = desk.bytes_sent
    shown.show(["progress  10 %"])
    assert desk.bytes_sent == before
    shown.show(["progress  20 %"])
    assert desk.bytes_sent - before == 6 + 24
    before, before_ns = desk.bytes_sent, desk.time.now
    shown.restore()
    assert desk.bytes_sent - before == 35 + 8 * (6 + 21 * 24)
    assert desk.time.now - before_ns > 8 * (desk.bytes_sent - before) * 250


def test_every_character_can_be_told_from_every_other() -> None:
    desk, shown = screen()
    text = string.printable[:95] + "°"
    lines = [text[k : k + 21] for k in range(0, len(text), 21)]
    shown.show(lines, 1)
    assert "".join(line.ljust(21) for line in text_lines(desk.model.picture())[:5]).rstrip() == text.rstrip()
    assert sorted(CHARACTERS) == sorted(text)


def test_what_is_no_character_is_told_as_such() -> None:
    desk, shown = screen()
    shown.show(["a\N{GREEK SMALL LETTER ALPHA}b"])
    assert text_lines(desk.model.picture())[0] == "a?b"
    desk.driver.put(0, 0, 1, b"\xff")
    assert text_lines(desk.model.picture())[0] == UNKNOWN + "?b"
