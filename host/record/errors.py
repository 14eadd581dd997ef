"""The one error that a person's own mistake becomes, and the hint that goes with a misspelt name."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class UserError(Exception):
    """A mistake in what the user asked for: the command line shows the message alone and exits with 2.

    The message says in one go what is wrong, where, with which value, and how a valid one looks.
    """


def did_you_mean(value: str, known: Iterable[str]) -> str:
    """A hint for a misspelt name: the nearest known one, or else all of them."""
    names = sorted(known)
    near = difflib.get_close_matches(value, names, n=1)
    if near:
        return f"did you mean {near[0]!r}?"
    return "known: " + (", ".join(names) or "none")
