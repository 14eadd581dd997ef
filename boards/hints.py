"""The hint that goes with a misspelt name."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


def did_you_mean(value: str, known: Iterable[str], otherwise: str = "known") -> str:
    """The nearest known name, or else all of them, with `otherwise` in front."""
    names = sorted(known)
    near = difflib.get_close_matches(value, names, n=1)
    if near:
        return f"did you mean {near[0]!r}?"
    return f"{otherwise}: " + (", ".join(names) or "none")
