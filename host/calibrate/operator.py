"""Who stands at the board: reads its screen, presses its keys, and has the table do what the screen asks for.

Nothing goes past the panel: what is not on the screen is not known here.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import NDArray

from firmware.apps.gfsins.menu_tree import LABELS
from hal.emulated.virtual_time import SECOND
from host.calibrate.table_world import TableWorld, level
from host.record.errors import UserError
from host.run.panel import Panel
from host.run.session import RunSession

LOOK_NS = SECOND // 10
SETTLE_NS = 3 * SECOND // 10
"""From the end of a turn to the key."""
LONGEST_S = 60.0
"""Until the board asks for the next thing."""
MOST_REFUSALS = 5
"""Of one position."""
PATIENCE_NS = 3 * SECOND
"""After a refusal."""
WARNED_NS = 15 * SECOND
"""From power-up, until a warning on the first page is believed."""
SPIN_S = 5.0
ENDS = "done", "FAILED"
"""Of a procedure, at the end of its title."""
FIRST_PAGE = "SETTINGS", "! "
MOST_PAGES = 10
"""On top of each other."""
TITLE = 12
"""Characters of a title that always stand."""
TWELVE = re.compile(r"\d+/\d+ x ([NSEWUD]), y ([NSEWUD]), z ([NSEWUD])")
TURN = re.compile(r"\d+/\d+ ([xyz]) up ([+-]\d+) deg/s")
HEADING = re.compile(r"\d+/\d+ heading (\d+)")
AT_REST = re.compile(r"\d+/\d+ level, at rest")
TURN_NOW = re.compile(r"turn now ([+-]\d+) deg/s")
DISPLAY_ROWS, ROW_HEIGHT = 8, 8
LIT = 8
POINTS = {"N": (1, 0, 0), "S": (-1, 0, 0), "E": (0, 1, 0), "W": (0, -1, 0), "D": (0, 0, 1), "U": (0, 0, -1)}
"""In north, east, down: the operator's own reading of the letters."""
UPWARDS = {"x": "UEN", "y": "NUE", "z": "ENU"}
"""Attitudes with one axis up."""
ALIGNED_AT = math.radians(40.0)


@dataclass
class Account:
    """One procedure as the operator saw it."""

    name: str
    done: bool = False
    lines: list[str] = field(default_factory=list)
    """The screen of its result."""
    refusals: list[str] = field(default_factory=list)
    took_s: float = 0.0


class Operator:
    """At one session in settings mode."""

    def __init__(
        self, session: RunSession, world: TableWorld, tick: Callable[[float], None] | None = None
    ) -> None:
        if session.panel is None or session.panel.display is None or session.panel.keypad is None:
            raise UserError(f"board {session.setup.board.name} has no display and keys to calibrate it with")
        self._session = session
        self._world = world
        self._panel: Panel = session.panel
        self._tick = tick
        self._axis = "z"

    def calibrate(self, name: str) -> Account:
        """A whole procedure, from the first page and back to it."""
        begun_ns = self._session.now_ns
        account = Account(name)
        self._go_home()
        self._choose(LABELS[name])
        self._press("OK")
        self._press("OK")
        self._work(account)
        account.took_s = (self._session.now_ns - begun_ns) / SECOND
        self._press("OK" if account.done else "BACK")
        return account

    def _go_home(self) -> None:
        """To the first page, from wherever a reset of the board has left it."""
        for _ in range(MOST_PAGES):
            lines = self._until(lambda lines: bool(lines[-1]) or lines[0].startswith(FIRST_PAGE), "a page")
            if lines[0].startswith(FIRST_PAGE):
                return
            self._press("BACK")

    # -- the screen --------------------------------------------------------------------------------

    def wait_for_menu(self) -> None:
        """Until the first page is there, and with it the sensors; a warning that stays is no obstacle. Raises
        UserError."""
        begun_ns = self._session.now_ns

        def is_there(lines: list[str]) -> bool:
            waited_ns = self._session.now_ns - begun_ns
            return lines[0].startswith(FIRST_PAGE if waited_ns > WARNED_NS else FIRST_PAGE[0])

        self._until(is_there, f"{FIRST_PAGE[0]!r}")

    def _until(self, seen: Callable[[list[str]], bool], what: str) -> list[str]:
        begun_ns = self._session.now_ns
        while True:
            lines = self._panel.lines()
            if seen(lines):
                return lines
            if self._session.now_ns - begun_ns > LONGEST_S * SECOND:
                shown = " | ".join(line for line in lines if line) or "nothing"
                raise UserError(f"the board's screen never showed {what}; it shows: {shown}")
            self._pass(LOOK_NS)

    def _pass(self, duration_ns: int) -> None:
        self._session.run_until(self._session.now_ns + duration_ns)
        if self._tick is not None:
            self._tick(self._session.now_ns / SECOND)

    def _press(self, key: str) -> None:
        self._panel.press(key)
        self._pass(4 * LOOK_NS)

    def _choose(self, label: str) -> None:
        """Go down the list until the marked line is that one."""
        for _ in range(20):
            if self._marked() == label:
                return
            self._press("DOWN")
        raise UserError(
            f"the board's menu has no item {label!r}; it shows: {' | '.join(self._panel.lines())}"
        )

    def _marked(self) -> str:
        """The line that is dark on light."""
        lit = (self._panel.picture() >= LIT).reshape(DISPLAY_ROWS, -1).mean(axis=1)
        row = int(np.argmax(lit))
        return self._panel.lines()[row].strip() if lit[row] > 0.5 else ""

    # -- a procedure -------------------------------------------------------------------------------

    def _work(self, account: Account) -> None:
        answered, turned, in_a_row = "", "", 0
        title = LABELS[account.name][:TITLE]
        while True:
            lines = self._until(partial(_asks, title, turned), "what to do next")
            if lines[0].endswith(ENDS):
                account.done = lines[0].endswith(ENDS[0])
                account.lines = self._whole_result()
                return
            if not lines[0].startswith(title):
                account.lines = ["the board has begun anew"]
                return
            asked = lines[2]
            if TURN_NOW.fullmatch(asked):
                self._turn(asked)
                turned = asked
                continue
            turned = ""
            in_a_row = in_a_row + 1 if asked == answered else 0
            if in_a_row:
                account.refusals.append(lines[6])
                if in_a_row > MOST_REFUSALS:
                    account.lines = [f"given up: {lines[6]}"]
                    self._press("BACK")
                    return
                self._pass(PATIENCE_NS)
            self._bring_into(asked)
            self._press("OK")
            answered = asked
            self._until(partial(_takes, title, asked), "that it collects")

    def _whole_result(self) -> list[str]:
        """All of it, line by line below the title."""
        self._pass(4 * LOOK_NS)  # the rest of the picture
        found = [line for line in self._panel.lines()[1:-1] if line]
        for _ in range(20):
            self._press("DOWN")
            now = [line for line in self._panel.lines()[1:-1] if line]
            if not now or now[-1] in found:
                break
            found.append(now[-1])
        return found

    def _bring_into(self, prompt: str) -> None:
        table, now_ns = self._world.table, self._session.now_ns
        wanted = self._attitude(prompt)
        if not np.allclose(wanted, table.attitude, atol=1e-9):
            table.turn_to(wanted, now_ns)
        until_ns = max(table.rests_from_ns, now_ns) + SETTLE_NS
        while self._session.now_ns < until_ns:
            self._pass(min(LOOK_NS, until_ns - self._session.now_ns))

    def _attitude(self, prompt: str) -> NDArray[np.float64]:
        """C_n_b. Raises UserError for a prompt that it does not understand."""
        twelve, turn, heading = TWELVE.fullmatch(prompt), TURN.fullmatch(prompt), HEADING.fullmatch(prompt)
        if twelve:
            return _pointed(twelve.groups())
        if turn:
            self._axis = turn.group(1)
            return _pointed(UPWARDS[self._axis])
        if heading:
            return level(math.radians(int(heading.group(1))) + self._world.declination)
        if AT_REST.fullmatch(prompt):
            return level(ALIGNED_AT)
        raise UserError(f"the board's screen asks for {prompt!r}, which nobody understands")

    def _turn(self, prompt: str) -> None:
        told = TURN_NOW.fullmatch(prompt)
        assert told is not None
        axis = np.eye(3)["xyz".index(self._axis)]
        self._world.table.spin(axis, math.radians(int(told.group(1))), SPIN_S, self._session.now_ns)


def _pointed(letters: Sequence[str]) -> NDArray[np.float64]:
    """C_n_b of a body whose x, y, z point there. Raises UserError where no body can."""
    c_nb = np.array([POINTS[letter] for letter in letters], np.float64).T
    if not np.isclose(np.linalg.det(c_nb), 1.0):
        raise UserError(f"the board's screen asks for x, y, z to {', '.join(letters)}: no table can do that")
    return c_nb


def _asks(title: str, turned: str, lines: list[str]) -> bool:
    """Whether something is to be done: a key, another turn than the last, or the end, also by a reset."""
    if lines[0].endswith(ENDS) or not lines[0].startswith(title):
        return True
    if TURN_NOW.fullmatch(lines[2]):
        return lines[2] != turned
    return "OK: it stands so" in lines[7]


def _takes(title: str, asked: str, lines: list[str]) -> bool:
    """Whether the key was heard: another prompt, or a refusal."""
    return lines[2] != asked or bool(lines[6]) or not lines[0].startswith(title)
