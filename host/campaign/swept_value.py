"""What a text of `--set` means as a value: `0.1` and `0.10` are one."""

from __future__ import annotations

import sys
import tomllib


def swept_value(text: str) -> str | float | bool:
    """Numbers and truth values as such, everything else as it was written."""
    try:
        value = tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text
    if isinstance(value, bool):
        return value
    if isinstance(value, int | float):
        return float(value) if abs(value) <= sys.float_info.max else text
    return value if isinstance(value, str) else text
