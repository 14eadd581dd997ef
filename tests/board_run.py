"""A run of a whole board, as tests of every board look at it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from host.record.result import RunResult


@dataclass(frozen=True)
class Driven:
    """A run, and what the board said."""

    result: RunResult

    def column(self, name: str) -> NDArray[np.float64]:
        """Of its solutions (thinned where there are many)."""
        assert self.result.data is not None
        return self.result.data.solution.column(name)

    def words(self) -> list[tuple[float, str]]:
        """(s, text) of everything the board said."""
        return [(event.at_s, event.text) for event in self.result.events if event.source == "board"]

    def said(self, text: str, after_s: float = 0.0) -> float:
        """When it first said something that begins like this."""
        for at_s, words in self.words():
            if at_s >= after_s and words.startswith(text):
                return at_s
        raise AssertionError(f"never said {text!r} after {after_s:g} s; it said {self.words()}")

    def worst(self, name: str, from_s: float, to_s: float) -> float:
        """Largest error called `name` between two times."""
        t = self.column("t_s")
        chosen = (t >= from_s) & (t < to_s)
        assert chosen.any(), f"no solution between {from_s:g} and {to_s:g} s"
        return float(np.abs(self.column(name)[chosen]).max())


def fault(
    kind: str, target: str, at_s: float, duration_s: float | None = None, **parameters: float | str
) -> str:
    """One fault as `--set fault=[…]` takes it; parameters that are texts as they stand in TOML."""
    text = f'kind = "{kind}", target = "{target}", at_s = {at_s}'
    if duration_s is not None:
        text += f", duration_s = {duration_s}"
    if parameters:
        text += ", parameters = { " + ", ".join(f"{k} = {v}" for k, v in parameters.items()) + " }"
    return "{ " + text + " }"
