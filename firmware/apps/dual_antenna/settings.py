"""What a profile of the board may set for its two programs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from firmware.apps.profile_keys import check_keys

SAMPLES_PER_S = 200

CHOICES: dict[str, tuple[Any, ...]] = {
    "precision": ("float64", "float32"),
    "output_rate_hz": (1, 2, 5, 10, 20, 50, 100, 200),
}
"""The values that each setting may take; settings of type bool may be true or false."""

COMPASS_S = (60.0, 3600.0)


@dataclass(frozen=True)
class Settings:
    """One profile."""

    precision: str = "float64"
    """The DSP computes in double precision as fast as it needs to; "float32" shows what that is worth."""
    attitude: bool = True
    """False: what the receiver tells of attitude is not used."""
    gyro_compass_s: float = 300.0
    """Without a heading for so long at rest, the gyros' own is taken."""
    output_rate_hz: int = 10
    task_frames: bool = False
    """Tell the load of each task every second, for displays."""

    @property
    def steps_per_output(self) -> int:
        """Strapdown steps from one solution to the next."""
        return SAMPLES_PER_S // self.output_rate_hz

    @classmethod
    def of(cls, profile: Mapping[str, Any]) -> Settings:
        """Settings from a profile table. Raises ValueError for what no program could mean."""
        known = {field.name for field in fields(cls)}
        check_keys(profile, known, {"gyro_compass_s": _check_time}, CHOICES)
        return cls(**profile)


def _check_time(key: str, value: Any) -> None:
    low, high = COMPASS_S
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise ValueError(
            f"profile key {key} = {value!r} is no number from {low:g} to {high:g}; for example 300.0"
        )
