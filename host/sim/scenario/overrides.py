"""Overrides from the command line: `gnss.latency_s=0.1`, `outage.0.duration_s=30`."""

from __future__ import annotations

import copy
import tomllib
from collections.abc import Iterable
from typing import Any

from host.sim.scenario.errors import ScenarioError

EXAMPLE = "for example --set gnss.latency_s=0.1"


def apply_overrides(data: dict[str, Any], overrides: Iterable[str]) -> dict[str, Any]:
    """A copy of `data` with each `dotted.path=value` put in; values as in TOML, bare words are text.

    Tables are made where they are missing; whether a key may exist at all is for the schema to say.
    Raises ScenarioError when an override is not of this form or leads into something that is no table.
    """
    result = copy.deepcopy(data)
    for override in overrides:
        path, equals, text = override.partition("=")
        keys = [key.strip() for key in path.split(".")]
        if not equals or not all(keys):
            raise ScenarioError(f"--set {override}: must be key=value; {EXAMPLE}")
        _put(result, keys, _value(text.strip()), override)
    return result


def _value(text: str) -> Any:
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


def _put(table: Any, keys: list[str], value: Any, override: str) -> None:
    for key in keys[:-1]:
        if isinstance(table, list):
            table = table[_index(table, key, override)]
        else:
            table = table.setdefault(key, {})
        if not isinstance(table, dict | list):
            raise ScenarioError(f"--set {override}: {key!r} is a value ({table!r}), not a table; {EXAMPLE}")
    if isinstance(table, list):
        table[_index(table, keys[-1], override)] = value
    else:
        table[keys[-1]] = value


def _index(items: list[Any], key: str, override: str) -> int:
    if not key.isdecimal() or int(key) >= len(items):
        known = f"0 … {len(items) - 1}" if items else "none, the list is empty"
        raise ScenarioError(f"--set {override}: {key!r} is not an entry of this list (entries: {known})")
    return int(key)
