"""What a profile of the board may set for this program."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from firmware.apps.profile_keys import check_keys
from firmware.nav.attitude.flags import METHOD_NAMES

ITERATIONS_PER_S = 125
"""One every 8 ms."""

CHOICES: dict[str, tuple[Any, ...]] = {
    "arithmetic": ("float32", "fixed", "float64"),
    "update": METHOD_NAMES,
    "output_rate_hz": (1, 5, 25, 125),
}
"""The values that each setting may take; settings of type bool may be true or false."""

RANGES: dict[str, tuple[float, float, float]] = {
    "latitude_deg": (-89.0, 89.0, 40.85),
    "longitude_deg": (-180.0, 180.0, 111.7),
    "height_m": (-1_000.0, 20_000.0, 1_063.0),
    "declination_deg": (-180.0, 180.0, -5.2),
    "initial_yaw_deg": (0.0, 360.0, 62.0),
    "alignment_s": (0.5, 60.0, 5.0),
}
"""Lowest and highest possible number, and an example."""


@dataclass(frozen=True)
class Settings:
    """One profile."""

    arithmetic: str = "float32"
    """"fixed": 32-bit two's complement without any float; "float64": for error budgets only."""
    update: str = "rk4"
    """How the attitude is carried from one iteration to the next."""
    drift_compensation: bool = True
    """Accelerometer and magnetometer hold the attitude (the document's outlook, section 6.2)."""
    output_rate_hz: int = 25
    latitude_deg: float = 40.85
    """Where navigation begins; it has no receiver that would tell it. Unless told otherwise, at Hohhot."""
    longitude_deg: float = 111.70
    height_m: float = 1065.0
    declination_deg: float = -6.36
    """Of the magnetic field there, east positive."""
    magnetometer: bool = True
    """False: it is not used, yaw begins at `initial_yaw_deg`."""
    initial_yaw_deg: float | None = None
    """True heading at the start; None: from the magnetometer."""
    alignment_s: float = 5.0
    """How long it stands still to level itself."""
    self_test: bool = True
    """Let the sensor test itself at the start."""
    task_frames: bool = False
    """Tell the load of each task every second, for displays."""

    @property
    def iterations_per_output(self) -> int:
        """From one solution to the next."""
        return ITERATIONS_PER_S // self.output_rate_hz

    @classmethod
    def of(cls, profile: Mapping[str, Any]) -> Settings:
        """Settings from a profile table. Raises ValueError for what no program could mean."""
        check_keys(
            profile, {field.name for field in fields(cls)}, dict.fromkeys(RANGES, _check_number), CHOICES
        )
        settings = cls(**profile)
        if not settings.magnetometer and settings.initial_yaw_deg is None:
            raise ValueError(
                "magnetometer = false: nothing tells the heading at the start; for example"
                " initial_yaw_deg = 62.0"
            )
        return settings


def _check_number(key: str, value: Any) -> None:
    low, high, example = RANGES[key]
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if not is_number or not low <= value <= high or (key == "initial_yaw_deg" and value == high):
        raise ValueError(
            f"profile key {key} = {value!r} is no number from {low:g} to {high:g}; for example {example:g}"
        )
