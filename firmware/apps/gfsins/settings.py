"""What a profile of the board may set for its two programs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from firmware.apps.gfsins import entered
from firmware.apps.profile_keys import check_keys
from firmware.nav.gyro_free.layout import METHOD_NAMES, RESET_NAMES

TICKS_PER_S = 200
CHOICES: dict[str, tuple[Any, ...]] = {
    "feed": ("adxl345", "equivalent"),
    "reset": RESET_NAMES,
    "method": METHOD_NAMES,
    "output_rate_hz": (1, 2, 5, 10, 20, 50, 100, 200),
}
"""The values that each setting may take; settings of type bool may be true or false."""
RANGES = {"declination_deg": (-180.0, 180.0), "alignment_s": (2.0, 600.0), **entered.RANGES}


@dataclass(frozen=True)
class Settings:
    """One profile."""

    feed: str = "equivalent"
    """Where rate and force come from: the accelerometers' registers, or test equipment beside them."""
    reset: str = "fusion_feedback"
    method: str = "fused"
    declination_deg: float = 0.0
    """East positive: what is between magnetic and true north here."""
    alignment_s: float = 10.0
    """At rest or straight on, before navigation begins."""
    begin_latitude_deg: float | None = None
    """Place, velocity and attitude at power-up, where an operator enters them (entered.py)."""
    begin_longitude_deg: float | None = None
    begin_height_m: float | None = None
    begin_north_mps: float | None = None
    begin_east_mps: float | None = None
    begin_down_mps: float | None = None
    begin_heading_deg: float | None = None
    begin_pitch_deg: float | None = None
    begin_roll_deg: float | None = None
    output_rate_hz: int = 10
    task_frames: bool = False
    """Tell the load of each task every second, for displays."""

    @property
    def ticks_per_output(self) -> int:
        """From one solution to the next."""
        return TICKS_PER_S // self.output_rate_hz

    @property
    def entered(self) -> dict[str, float]:
        """What an operator has entered of the beginning."""
        names = (name for group in entered.GROUPS for name in group)
        return {name: value for name in names if (value := getattr(self, name)) is not None}

    @classmethod
    def of(cls, profile: Mapping[str, Any]) -> Settings:
        """Settings from a profile table. Raises ValueError for what no program could mean."""
        known = {field.name for field in fields(cls)}
        check_keys(profile, known, dict.fromkeys(RANGES, _check_range), CHOICES)
        for names in entered.GROUPS:
            entered.group(profile, names)
        return cls(**profile)


def _check_range(key: str, value: Any) -> None:
    low, high = RANGES[key]
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise ValueError(
            f"profile key {key} = {value!r} is no number from {low:g} to {high:g};"
            f" for example {Settings.__dataclass_fields__[key].default or 0.0}"
        )
