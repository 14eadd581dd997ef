"""Rows of tables in a capture, before somebody counts on their columns: any program can have written them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from host.record.errors import UserError

TIME = "t_s"
LARGEST = 1e15
"""What is larger is no quantity of a vehicle."""


def check_numbers(row: Mapping[str, Any], columns: Iterable[str], where: str) -> None:
    """That each of `columns` is a number or null, and the time a number. Raises UserError."""
    for name in (TIME, *columns):
        value = row.get(name, "")
        is_number = type(value) in (int, float) and abs(value) < LARGEST
        if is_number or (name != TIME and (value is None or value != value)):
            continue
        found = f"{name!r} is {value!r:.40}" if name in row else f"the column {name!r} is missing"
        needed = "a number" if name == TIME else "a number or null"
        raise UserError(f"{where} is damaged: {found}; {needed} belongs there")
