"""The hint that goes with a misspelt name."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

MOST_TOLD = 40
SOME_TOLD = 12


def did_you_mean(value: str, known: Iterable[str], otherwise: str = "known") -> str:
    """The nearest known name, or else all of them (of very many some), with `otherwise` in front."""
    names = sorted(known)
    near = difflib.get_close_matches(value, names, n=1)
    if near:
        return f"did you mean {near[0]!r}?"
    if len(names) > MOST_TOLD:
        some = difflib.get_close_matches(value, names, n=SOME_TOLD, cutoff=0.0)
        return f"{otherwise}, {len(names)} in all: {', '.join(some)} …"
    return f"{otherwise}: " + (", ".join(names) or "none")
