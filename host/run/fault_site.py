"""Where and when one fault is to strike, and what it does there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from boards.assembly import AssembledBoard
from boards.hints import did_you_mean
from hal.emulated.virtual_time import FAR
from host.record.errors import UserError
from host.sim.scenario.schema import Fault


class Effect(NamedTuple):
    """What a fault does where it was put."""

    fired: Callable[[], int]
    """How often it has struck."""
    lift: Callable[[], None] | None = None
    """Ends it before its time. None: it is over in an instant, or ends by itself."""


def name_of(fault: Fault) -> str:
    """What a fault is called in results; no two faults of a scenario are called alike."""
    return fault.name or f"{fault.kind} {fault.target}"


@dataclass(frozen=True)
class Site:
    """Where and when one fault is to strike."""

    fault: Fault
    board: AssembledBoard
    start: int
    end: int
    seed: int

    def of(self, table: dict[str, Any], what: str) -> Any:
        """The target in one of the board's tables."""
        return target_in(self.fault, table, what)

    @property
    def stream(self) -> dict[str, Any]:
        """Seed and name of the fault's own randomness; names of channels of chips hold no blanks."""
        name, label = name_of(self.fault), f"{self.fault.kind} {self.fault.target}"
        unnamed = name.startswith(label) and ":" not in name
        return {"seed": self.seed, "name": name if unnamed else f"{label}: {name}"}

    def parameters(self, **defaults: Any) -> dict[str, Any]:
        """The fault's parameters over their defaults. Raises ValueError for an unknown one."""
        for key, value in self.fault.parameters.items():
            if key not in defaults:
                known = ", ".join(f"{name} = {default!r}" for name, default in defaults.items()) or "none"
                raise ValueError(f"parameters.{key} = {value!r} is unknown; parameters are: {known}")
            if not _is_like(value, defaults[key]):
                raise ValueError(
                    f"parameters.{key} = {value!r} is of the wrong kind;"
                    f" for example {key} = {defaults[key]!r}"
                )
        return {**defaults, **self.fault.parameters}


Maker = Callable[[Site], Effect]
"""Puts a kind of fault where it strikes. Raises ValueError for what cannot be."""


def _is_like(value: Any, example: Any) -> bool:
    """Whether a parameter is of the kind of its default; a whole number may stand for any number."""
    if isinstance(example, float):
        return isinstance(value, int | float) and not isinstance(value, bool)
    return type(value) is type(example)


def target_in(fault: Fault, table: Any, what: str) -> Any:
    """The fault's target in a table of parts. Raises UserError when it is not there."""
    if fault.target not in table:
        hint = did_you_mean(fault.target, table)
        raise UserError(f"fault {name_of(fault)!r}: the board has no {what} {fault.target!r}; {hint}")
    return table[fault.target] if isinstance(table, dict) else None


def once(site: Site, begin: Callable[[], Any], end: Callable[[], Any] | None = None) -> Effect:
    """A fault that happens at an instant, and perhaps ends at another."""
    fired = 0
    over = False

    def strike() -> None:
        nonlocal fired
        if not over:
            fired += 1
            begin()

    def pass_over() -> None:
        nonlocal over
        if fired and not over and end is not None:
            end()
        over = True

    site.board.time.at(site.start, strike)
    if end is None:
        return Effect(lambda: fired)
    if site.end < FAR:
        site.board.time.at(site.end, pass_over)
    return Effect(lambda: fired, pass_over)
