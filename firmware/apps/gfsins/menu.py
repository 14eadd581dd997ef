"""Pages on top of each other: the topmost is shown and gets the keys, BACK goes to the one below."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from firmware.drivers.text_screen import CHARACTERS, LINES

ROWS = LINES - 1
"""Below the title."""


class Page(Protocol):
    """One page of the menu."""

    @property
    def marked(self) -> int | None:
        """The line that is marked."""
        ...

    def lines(self) -> list[str]:
        """What stands on it now."""
        ...

    def press(self, key: str, menu: Menu) -> None:
        """A key, also BACK."""
        ...


class Menu:
    """The stack of pages. `has_left`: the operator wants out of settings mode."""

    def __init__(self, first: Page) -> None:
        self.has_left = False
        self._pages: list[Page] = [first]

    @property
    def marked(self) -> int | None:
        """The marked line of the page that is shown."""
        return self._pages[-1].marked

    def lines(self) -> list[str]:
        """The page that is shown."""
        return self._pages[-1].lines()

    def press(self, key: str) -> None:
        """A key of the keypad."""
        self._pages[-1].press(key, self)

    def open(self, page: Page) -> None:
        """Put a page on top."""
        self._pages.append(page)

    def back(self) -> None:
        """Take the topmost page off; the first one stays."""
        if len(self._pages) > 1:
            self._pages.pop()


@dataclass(frozen=True)
class Item:
    """One line to choose: its text as of now, and what OK does."""

    text: Callable[[], str]
    chosen: Callable[[Menu], None]


class Choice:
    """Implements `Page`: a title and items, of which seven are in sight."""

    def __init__(self, title: str, items: Sequence[Item]) -> None:
        self._title = title
        self._items = items
        self._at = 0
        self._first = 0

    @property
    def marked(self) -> int:
        """The item that OK takes."""
        return 1 + self._at - self._first

    def lines(self) -> list[str]:
        """Title, with the place in a list that does not fit, and items."""
        count = len(self._items)
        place = f"{self._at + 1}/{count}" if count > ROWS else ""
        shown = self._items[self._first : self._first + ROWS]
        return [two_ends(self._title, place), *(item.text() for item in shown)]

    def press(self, key: str, menu: Menu) -> None:
        """UP and DOWN go round, OK or RIGHT choose."""
        if key in ("UP", "DOWN"):
            self._at = (self._at + (1 if key == "DOWN" else -1)) % len(self._items)
            self._first = max(self._at - ROWS + 1, min(self._first, self._at))
        elif key in ("OK", "RIGHT"):
            self._items[self._at].chosen(menu)
        else:
            menu.back()


def two_ends(left: str, right: str) -> str:
    """A line with a text at each end; the left one gives way."""
    room = max(0, CHARACTERS - len(right))
    return left[: max(0, room - bool(right))].ljust(room) + right[:CHARACTERS]
