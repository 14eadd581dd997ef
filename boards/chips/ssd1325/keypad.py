"""Keys beside the display: one net each, low while the key is held; contacts bounce.

The document says "keyboard" and no more; six keys on inputs of their own are this project's choice.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from hal.emulated.virtual_time import VirtualTime

KEYS = ("UP", "DOWN", "LEFT", "RIGHT", "OK", "BACK")
BOUNCES = 3
BOUNCE_NS = 400_000


class KeyNet(Protocol):
    """What a key needs of its net."""

    def set(self, level: bool) -> None:
        """Drive the level."""
        ...


class Keypad:
    """Six keys; nobody's finger but the test's, the scenario's or the live view's."""

    feels = "none"

    def __init__(self, time: VirtualTime, *, bounces: int = BOUNCES, name: str = "keypad") -> None:
        if bounces < 0:
            raise ValueError(
                f"{name}: bounces = {bounces}; a contact bounces 0 or more times, like {BOUNCES}"
            )
        self.name = name
        self.pins: dict[str, KeyNet | None] = dict.fromkeys(KEYS)
        self.held: set[str] = set()
        self._time = time
        self._bounces = bounces

    def wired(self) -> None:
        """The nets are connected: no key is held, all of them are high."""
        for key in KEYS:
            self._drive(key, True)
        self.held.clear()

    def press(self, key: str) -> None:
        """Hold a key from now on. ValueError for a key that is not there."""
        self._check(key)
        self.held.add(key)
        self._change(key, False)

    def release(self, key: str) -> None:
        """Let it go, now."""
        self._check(key)
        self.held.discard(key)
        self._change(key, True)

    def _check(self, key: str) -> None:
        if key not in self.pins:
            raise ValueError(f"{self.name}: there is no key {key!r}; there are {', '.join(KEYS)}")

    def _change(self, key: str, level: bool) -> None:
        self._drive(key, level)
        for bounce in range(self._bounces):
            start = self._time.now + (2 * bounce + 1) * BOUNCE_NS
            self._time.at(start, self._later(key, not level))
            self._time.at(start + BOUNCE_NS, self._later(key, level))

    def _later(self, key: str, level: bool) -> Callable[[], None]:
        return lambda: self._drive(key, level)

    def _drive(self, key: str, level: bool) -> None:
        net = self.pins[key]
        if net is not None:
            net.set(level)
