"""What an operator does at the board: how its mode switch stands at power-up, which keys are pressed when."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from host.sim.schema import Table

HELD_S = 0.15
"""A press of an ordinary finger."""
SHORTEST_S = 0.001
LATEST_S = 1e7


@dataclass(frozen=True)
class KeyPress:
    """A key that goes down at `at_s` and is held."""

    at_s: float
    key: str
    held_s: float = HELD_S

    @property
    def end_s(self) -> float:
        """When it is let go."""
        return self.at_s + self.held_s


def key_presses(value: Any) -> list[KeyPress]:
    """From the list as it is written. Raises ValueError that tells which entry is wrong, and why."""
    if not isinstance(value, list):
        raise ValueError("must be a list of [second, key] or [second, key, held for s]")
    presses = [_press(number, entry) for number, entry in enumerate(value, start=1)]
    down: dict[str, KeyPress] = {}
    for press in sorted(presses, key=lambda one: one.at_s):
        before = down.get(press.key)
        if before is not None and press.at_s <= before.end_s:
            raise ValueError(
                f"the key {press.key} goes down at {press.at_s:g} s while it is held from {before.at_s:g} to"
                f" {before.end_s:g} s; let it go before"
            )
        down[press.key] = press
    return presses


def _press(number: int, entry: Any) -> KeyPress:
    if isinstance(entry, KeyPress):
        return entry
    where = f"entry {number}, {entry!r}:"
    if not isinstance(entry, list) or not 2 <= len(entry) <= 3:
        raise ValueError(f"{where} must be [second, key] or [second, key, held for s]")
    at_s, key = entry[0], entry[1]
    held_s = entry[2] if len(entry) == 3 else HELD_S
    if not isinstance(key, str) or not key:
        raise ValueError(f"{where} the key must be a text")
    if not _is_number(at_s) or not 0.0 <= at_s <= LATEST_S:
        raise ValueError(f"{where} the time must be a number of seconds in 0 … {LATEST_S:g}")
    if not _is_number(held_s) or not SHORTEST_S <= held_s <= LATEST_S:
        raise ValueError(f"{where} it must be held for a number of seconds in {SHORTEST_S:g} … {LATEST_S:g}")
    return KeyPress(float(at_s), key, float(held_s))


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


class Panel(Table):
    """Mode switch and keys; None and empty: nobody touches the board."""

    mode: str | None = Field(default=None, examples=["settings"])
    """A position of the board's mode switch; None: as the board's description has it."""
    keys: Annotated[list[KeyPress], BeforeValidator(key_presses)] = Field(
        default=[], examples=[[[2.0, "OK"], [3.5, "DOWN", 1.0]]]
    )

    @property
    def is_used(self) -> bool:
        """Whether the scenario says anything of it."""
        return self.mode is not None or bool(self.keys)
