"""Six keys on inputs of their own, low while held: debounced, a word for each press, repeated on held arrows.

`scan` is called at a steady rate, from a timer's interrupt; `take` hands the words over to the background. A
contact bounces for some 2.4 ms; a level counts when CALM_LOOKS looks in a row have seen it. A key that is low
when the board begins, or is held for longer than anybody holds a key, is stuck: it is told and says nothing
more until it has been let go.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from typing import Final

from hal.pins import InputPin

KEYS: Final = ("UP", "DOWN", "LEFT", "RIGHT", "OK", "BACK")
REPEATING: Final = ("UP", "DOWN")
CALM_LOOKS: Final = 3
REPEAT_AFTER_S: Final = 0.6
REPEAT_EVERY_S: Final = 0.1
STUCK_S: Final = 15.0
WAITING_LIMIT: Final = 8
"""Presses that nobody takes are dropped beyond this."""


class Keypad:
    """`inputs`: a pin for each of KEYS."""

    def __init__(self, inputs: Mapping[str, InputPin], looks_per_s: int) -> None:
        self.dropped = 0
        self._pins = [inputs[key].read for key in KEYS]
        self._repeats = [key in REPEATING for key in KEYS]
        self._waiting: deque[str] = deque()
        self._repeat_after = round(REPEAT_AFTER_S * looks_per_s)
        self._repeat_every = max(1, round(REPEAT_EVERY_S * looks_per_s))
        self._stuck_after = round(STUCK_S * looks_per_s)
        self._different = [0] * len(KEYS)
        """Looks in a row that saw another level than the one that counts."""
        self._held = [self._stuck_after * (not read()) for read in self._pins]
        """For how many looks each key is down by now, 0: up."""

    def scan(self) -> None:
        """Look at all keys."""
        for k, read in enumerate(self._pins):
            held = self._held[k]
            if read() == (held > 0):  # high is up: this look sees a change
                self._different[k] += 1
                if self._different[k] >= CALM_LOOKS:
                    self._different[k] = 0
                    self._held[k] = 0 if held else 1
                    if not held:
                        self._say(k)
                continue
            self._different[k] = 0
            if held:
                self._hold(k, held)

    def take(self) -> str | None:
        """The next press, once."""
        return self._waiting.popleft() if self._waiting else None

    @property
    def stuck(self) -> tuple[str, ...]:
        """Keys that nobody can be holding."""
        return tuple(key for key, held in zip(KEYS, self._held, strict=True) if held >= self._stuck_after)

    def _hold(self, k: int, held: int) -> None:
        if held >= self._stuck_after:
            return
        self._held[k] = held + 1
        since = held - self._repeat_after
        if self._repeats[k] and since >= 0 and since % self._repeat_every == 0:
            self._say(k)

    def _say(self, k: int) -> None:
        if len(self._waiting) < WAITING_LIMIT:
            self._waiting.append(KEYS[k])
        else:
            self.dropped += 1
