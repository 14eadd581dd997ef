"""Bars and sparklines from block characters."""

from __future__ import annotations

import math
from collections.abc import Sequence

LEFT_BLOCKS = " ▏▎▍▌▋▊▉█"
LEVELS = "▁▂▃▄▅▆▇█"


def bar(share: float, width: int) -> str:
    """`width` characters, filled from the left by `share`, 0 … 1."""
    if not math.isfinite(share):
        share = 0.0
    eighths = round(min(max(share, 0.0), 1.0) * width * 8)
    whole, part = divmod(eighths, 8)
    return ("█" * whole + (LEFT_BLOCKS[part] if part else "")).ljust(width)


def sparkline(values: Sequence[float], largest: float, width: int) -> str:
    """The last `width` values between −`largest` and `largest`; a value that is none is a gap."""
    return "".join(
        LEVELS[min(max(int((value / largest + 1) * 4), 0), 7)] if math.isfinite(value) else " "
        for value in list(values)[-width:]
    ).rjust(width)
