"""Numbers for people: three significant digits, no exponents where avoidable, a dash for none."""

from __future__ import annotations

import math

NONE = "–"


def number(value: float | None, unit: str = "") -> str:
    """About three significant digits: 0.0312, 1.93, 12.4, 1,240."""
    if value is None or not math.isfinite(value):
        return NONE
    magnitude = abs(value)
    if magnitude >= 1e7 or 0 < magnitude < 1e-4:
        text = f"{value:.2e}"
    elif magnitude >= 100 or value == int(value):
        text = f"{value:,.0f}"
    else:
        decimals = 2 - math.floor(math.log10(magnitude)) if magnitude > 0 else 0
        text = f"{value:.{min(decimals, 6)}f}"
    return f"{text} {unit}".rstrip()


def percent(share: float | None) -> str:
    """A share 0 … 1 as a percentage."""
    if share is None or not math.isfinite(share):
        return NONE
    return f"{100 * share:.2f} %"


def counted(count: int, word: str) -> str:
    """`1 run`, `1,000 runs`."""
    return f"{count:,} {word}" if count == 1 else f"{count:,} {word}s"


def count(value: float | None) -> str:
    """A whole number with thousands separated."""
    return NONE if value is None else f"{value:,.0f}"
