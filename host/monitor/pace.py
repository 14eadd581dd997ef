"""The time of what is played: how it follows the clock on the wall, at a speed, with pauses and jumps."""

from __future__ import annotations

import time


class Pace:
    """`speed` 1 is real time, 10 ten times that, 0 as fast as it goes."""

    def __init__(self, speed: float) -> None:
        self.speed = speed
        self.paused = False
        self._wall_s: float | None = None
        self._at_s = 0.0

    def due_s(self, reached_s: float) -> float:
        """Up to when to play now. `reached_s`: so far it was played; what could not be played in time is
        not caught up with."""
        now = time.monotonic()
        wall_s, self._wall_s = self._wall_s, now
        if wall_s is None or self.paused:
            self._at_s = reached_s
        elif self.speed == 0:
            return float("inf")
        else:
            self._at_s = min(self._at_s, reached_s + self.speed) + (now - wall_s) * self.speed
        return self._at_s

    def jump(self, to_s: float) -> None:
        """Go on from there, now."""
        self._at_s = to_s
        self._wall_s = time.monotonic()

    def told(self) -> str:
        """For people."""
        if self.paused:
            return "paused"
        return "as fast as it goes" if self.speed == 0 else f"{self.speed:g} ×"
