"""Numbers as people read them. Nothing here raises, whatever a float holds, and nothing grows wide."""

from __future__ import annotations

import math
from datetime import UTC, datetime, timedelta

from firmware.link.frames import NO_DATE, NO_TIME_OF_DAY
from firmware.nav.flags import MODE_NAMES
from host.link.attitude import flag_name

UNKNOWN = "-"
GPS_EPOCH = datetime(1980, 1, 6, tzinfo=UTC)
DAY_MS = 86_400_000
LARGE = 1e6

ALARMING = frozenset({"gnss_lost", "position_uncertain", "numeric_restart", "imu_not_finite", "imu_stuck"})
ORDINARY = frozenset({"standstill", "constrained"})
MODE_STYLES = ("dim", "yellow", "yellow", "bold green", "bold red")


def number(value: float | None, decimals: int, width: int = 0) -> str:
    """`value` with so many decimals; huge ones by their power of ten, none and NaN as a dash."""
    if value is None or not math.isfinite(value):
        text = UNKNOWN
    elif abs(value) >= LARGE:
        text = f"{value:.1e}"
    else:
        text = f"{value:.{decimals}f}"
        if float(text) == 0.0:
            text = text.removeprefix("-")
    return text.rjust(width)


def degrees(radians: float) -> float:
    """Of an angle; NaN stays NaN."""
    return math.degrees(radians)


def count(value: float) -> str:
    """A count in at most five characters: 999, 12.3k, 4.5M."""
    if value < 10_000:
        return f"{value:.0f}"
    for unit in ("k", "M", "G"):
        value /= 1000
        if value < 1000:
            return f"{value:.1f}{unit}"
    return f"{value:.0e}"


def latitude(nanodeg: int) -> str:
    """With hemisphere."""
    return f"{abs(nanodeg) * 1e-9:.7f}° {'N' if nanodeg >= 0 else 'S'}"


def longitude(nanodeg: int) -> str:
    """With hemisphere."""
    return f"{abs(nanodeg) * 1e-9:.7f}° {'E' if nanodeg >= 0 else 'W'}"


def utc(time_of_day_ms: int, date_days: int) -> str:
    """Date and time to the tenth of a second, as far as they are known."""
    if time_of_day_ms == NO_TIME_OF_DAY or time_of_day_ms >= DAY_MS + 1000:
        return UNKNOWN
    leap = time_of_day_ms >= DAY_MS
    seconds, ms = divmod(time_of_day_ms - 1000 * leap, 1000)
    time = f"{seconds // 3600:02d}:{seconds // 60 % 60:02d}:{seconds % 60 + leap:02d}.{ms // 100}"
    if date_days == NO_DATE:
        return time
    return f"{GPS_EPOCH + timedelta(days=date_days):%Y-%m-%d} {time}"


def mode_name(mode: int) -> str:
    """Of navigation."""
    return MODE_NAMES[mode] if mode < len(MODE_NAMES) else f"mode {mode}"


def mode_style(mode: int) -> str:
    """Colour of a mode."""
    return MODE_STYLES[mode] if mode < len(MODE_STYLES) else "bold red"


def flag_names(flags: int) -> list[tuple[str, str]]:
    """(name, style) of every flag that is set, alarming ones first."""
    names = [flag_name(bit) for bit in range(32) if flags >> bit & 1]
    styled = [(name, flag_style(name)) for name in names]
    order = ["bold red", "yellow", "green"]
    return sorted(styled, key=lambda pair: order.index(pair[1]))


def flag_style(name: str) -> str:
    """Colour of a flag."""
    if name in ALARMING:
        return "bold red"
    return "green" if name in ORDINARY else "yellow"


def duration(seconds: float) -> str:
    """h:mm:ss."""
    if not math.isfinite(seconds) or seconds < 0:
        return UNKNOWN
    whole = int(seconds)
    return f"{whole // 3600}:{whole // 60 % 60:02d}:{whole % 60:02d}"
