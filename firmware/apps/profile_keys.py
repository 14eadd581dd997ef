"""The keys of a profile, checked against what a program knows; every program says its own."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Any


def check_keys(
    profile: Mapping[str, Any],
    known: Collection[str],
    numbers: Mapping[str, Callable[[str, Any], None]],
    choices: Mapping[str, tuple[Any, ...]],
) -> None:
    """ValueError for an unknown key or a value that is not possible.

    `numbers`: what checks the value of a key that takes a number; `choices`: the values of a key that takes
    one of some. Every other key is true or false.
    """
    for key, value in profile.items():
        if key not in known:
            keys = ", ".join(sorted(known))
            raise ValueError(f"profile key {key!r} (value {value!r}) is unknown; known keys: {keys}")
        if key in numbers:
            numbers[key](key, value)
            continue
        allowed = choices.get(key, (True, False))
        if value not in allowed or isinstance(value, bool) != isinstance(allowed[0], bool):
            told = ", ".join(repr(choice) for choice in allowed)
            raise ValueError(f"profile key {key} = {value!r} is not possible; choose one of {told}")
