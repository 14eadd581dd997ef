"""The board's panel from the operator's side: a mode switch, keys to press, a display to look at.

Keys and switch drive nets, which a capture records like all others: a strict replay needs no operator.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from boards.assembly import AssembledBoard
from boards.hints import did_you_mean
from hal.emulated.virtual_time import SECOND, VirtualTime
from host.record.errors import UserError
from host.record.screens import Picture, Screen
from host.run.screen_text import text_lines
from host.sim.scenario.panel_schema import HELD_S, KeyPress
from host.sim.scenario.panel_schema import Panel as Script

LOOK_EVERY_NS = 200_000_000
"""An operator's eye: a picture that stands for two looks has been seen."""
SCREENS_KEPT = 300


class Panel:
    """Switch, keypad and display of one board; those that it does not have are None."""

    def __init__(self, board: AssembledBoard) -> None:
        self.display = _first(board, "picture")
        self.keypad = _first(board, "press")
        self.switch = _first(board, "turn_to")
        self.screens: list[Screen] = []
        """Those that stood long enough to be read, each once; the last of them beyond SCREENS_KEPT."""
        self._time: VirtualTime = board.time
        self._board_name = board.description.name
        self._seen: Picture | None = None
        self._held: dict[str, int] = {}

    @property
    def keys(self) -> tuple[str, ...]:
        """What may be pressed."""
        return () if self.keypad is None else tuple(self.keypad.pins)

    def turn_to(self, mode: str) -> None:
        """Turn the mode switch. Raises UserError."""
        if self.switch is None:
            raise UserError(f"panel.mode = {mode!r}: board {self._board_name} has no mode switch")
        if mode not in self.switch.positions:
            hint = did_you_mean(mode, self.switch.positions)
            raise UserError(f"panel.mode = {mode!r}: the switch has no such position; {hint}")
        self.switch.turn_to(mode)

    def check_key(self, key: str, where: str) -> None:
        """Raises UserError for a key that is not there."""
        if self.keypad is None:
            raise UserError(f"{where}: board {self._board_name} has no keys")
        if key not in self.keys:
            raise UserError(f"{where}: there is no key {key!r}; {did_you_mean(key, self.keys)}")

    def press(self, key: str, held_s: float = HELD_S) -> None:
        """Press a key now, and let it go after `held_s`. Raises UserError, also while it is held."""
        self.check_key(key, "press")
        now = self._time.now
        if self._held.get(key, -1) >= now:
            raise UserError(f"press: {key} is held until {self._held[key] / SECOND:.3f} s")
        self._plan(key, now + 1, now + 1 + round(held_s * SECOND))

    def play(self, presses: list[KeyPress]) -> None:
        """Press keys at their times. Raises UserError."""
        for number, press in enumerate(presses, start=1):
            self.check_key(press.key, f"panel.keys, entry {number}")
            self._plan(press.key, round(press.at_s * SECOND), round(press.end_s * SECOND))

    def watch(self) -> None:
        """Keep what is seen on the display from now on."""
        if self.display is not None:
            self._time.at(self._time.now + LOOK_EVERY_NS, self._look)

    def picture(self) -> Picture:
        """What the display shows now. Raises UserError without one."""
        if self.display is None:
            raise UserError(f"board {self._board_name} has no display")
        shown: Picture = self.display.picture()
        return shown

    def lines(self) -> list[str]:
        """The text that stands on it."""
        return text_lines(self.picture())

    def _plan(self, key: str, down_ns: int, up_ns: int) -> None:
        keypad = self.keypad
        assert keypad is not None
        self._held[key] = up_ns
        self._time.at(down_ns, _once(keypad.press, key))
        self._time.at(up_ns, _once(keypad.release, key))

    def _look(self) -> int:
        now, picture = self._time.now, self.picture()
        stands = self._seen is not None and np.array_equal(picture, self._seen)
        is_new = not self.screens or not np.array_equal(picture, self.screens[-1].picture)
        if stands and is_new and (self.screens or picture.any()):
            if len(self.screens) == SCREENS_KEPT:
                self.screens.pop()
            self.screens.append(Screen(now - LOOK_EVERY_NS, picture))
        self._seen = picture
        return now + LOOK_EVERY_NS


def panel_of(board: AssembledBoard, script: Script) -> Panel | None:
    """The panel as the scenario has it used; None: the board has nothing of the kind. Raises UserError."""
    panel = Panel(board)
    if script.mode is not None:
        panel.turn_to(script.mode)
    panel.play(script.keys)
    if script.is_used:
        panel.watch()
    return None if panel.display is panel.keypad is panel.switch is None else panel


def _first(board: AssembledBoard, ability: str) -> Any:
    return next((chip for chip in board.chips.values() if hasattr(chip, ability)), None)


def _once(action: Callable[[str], None], key: str) -> Callable[[], None]:
    return lambda: action(key)
