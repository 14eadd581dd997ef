"""A running calibration or alignment: what the operator is to do, how far it is, what came out."""

from __future__ import annotations

from firmware.apps.gfsins.menu import ROWS, Menu, two_ends
from firmware.apps.gfsins.procedures import Procedures, State
from firmware.drivers.text_screen import CHARACTERS

RUNNING = (State.WAITING, State.COLLECTING, State.SOLVING)
HINTS = {
    State.IDLE: "OK: begin  BACK: no",
    State.WAITING: "OK: it stands so",
    State.COLLECTING: "wait",
    State.SOLVING: "the DSP solves",
    State.DONE: "OK: go on",
    State.FAILED: "OK: again  BACK: no",
}


class ProcedurePage:
    """Implements `Page`. The first BACK while it runs asks, the second one gives up."""

    marked: int | None = None

    def __init__(self, title: str, name: str, procedures: Procedures) -> None:
        self._title = title
        self._name = name
        self._procedures = procedures
        self._asks = False
        self._first = 0
        self._note = ""

    def lines(self) -> list[str]:
        """As of now."""
        procedures = self._procedures
        state = procedures.state
        if state in (State.DONE, State.FAILED):
            results = procedures.result_lines[self._first : self._first + ROWS - 1]
            head = two_ends(self._title, "done" if state is State.DONE else "FAILED")
            return [head, *(results + [""] * (ROWS - 1 - len(results))), HINTS[state]]
        if state is State.IDLE:
            return [self._title, "", "", self._note, "", "", "", HINTS[state]]
        place = f"position {min(procedures.position + 1, procedures.positions)} of {procedures.positions}"
        hint = "BACK again: give up" if self._asks else HINTS[state]
        refusal = "".join(procedures.result_lines[:1])
        told = [procedures.prompt, place, bar(procedures.progress), state.value, refusal]
        return [self._title, "", *told, hint]

    def press(self, key: str, menu: Menu) -> None:
        """A key."""
        procedures, state = self._procedures, self._procedures.state
        if state in (State.DONE, State.FAILED) and key in ("UP", "DOWN"):
            last = max(0, len(procedures.result_lines) - ROWS + 1)
            self._first = max(0, min(last, self._first + (1 if key == "DOWN" else -1)))
        elif key == "OK":
            self._go_on(state, menu)
        elif key == "BACK":
            self._go_back(state, menu)
        else:
            self._asks = False

    def _go_on(self, state: State, menu: Menu) -> None:
        procedures = self._procedures
        self._asks = False
        self._first = 0
        if state is State.IDLE:
            self._note = "" if procedures.start(self._name) else "cannot begin now"
        elif state is State.DONE:
            procedures.abandon()
            menu.back()
        elif state in (State.WAITING, State.FAILED):
            procedures.take()

    def _go_back(self, state: State, menu: Menu) -> None:
        if state in RUNNING and not self._asks:
            self._asks = True
            return
        if state is not State.IDLE:
            self._procedures.abandon()
        menu.back()


def bar(progress: float) -> str:
    """As wide as the screen: "[#####     ]  47 %"."""
    percent = f"{100 * max(0.0, min(1.0, progress)):4.0f} %"
    width = CHARACTERS - len(percent) - 2
    return "[" + ("#" * round(width * max(0.0, min(1.0, progress)))).ljust(width) + "]" + percent
