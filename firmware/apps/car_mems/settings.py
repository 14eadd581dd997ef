"""What a profile of the board may set for this program."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from firmware.apps.profile_keys import check_keys

CHOICES: dict[str, tuple[Any, ...]] = {
    "acquisition": ("timer", "data-ready"),
    "strapdown": ("mean", "two-sample"),
    "imu_rate_hz": (100,),
    "imu_bandwidth": ("normal", "osr2", "osr4"),
    "receiver": ("nmea-default", "nav-pvt"),
    "gnss_rate_hz": (1, 2, 5, 10),
    "output_rate_hz": (1, 2, 5, 10, 20, 50, 100),
    "precision": ("float32", "float64"),
}
"""The values that each setting may take; settings of type bool may be true or false."""

ANGLES_DEG = ("initial_yaw_deg",)


@dataclass(frozen=True)
class Settings:
    """One profile. Defaults are those of `full-rate`."""

    acquisition: str = "data-ready"
    """"timer": read at 100 Hz of the processor's timer; "data-ready": read when the chip says so."""
    strapdown: str = "two-sample"
    """"mean": ten-sample means, one step at 10 Hz; "two-sample": 100 Hz with coning and sculling terms."""
    imu_rate_hz: int = 100
    imu_bandwidth: str = "normal"
    receiver: str = "nav-pvt"
    """"nmea-default": the receiver as it comes, 9600 baud; "nav-pvt": 115200 baud and UBX NAV-PVT."""
    gnss_rate_hz: int = 1
    aiding: bool = True
    """Non-holonomic constraint and zero-velocity updates."""
    output_rate_hz: int = 10
    initial_yaw_deg: float | None = None
    """Heading known at the start, true north; None: taken from the course once the vehicle moves."""
    task_frames: bool = False
    """Tell the load of each task every second, for displays."""
    raw_output: bool = False
    """Tell on the host port everything that navigation takes in (`firmware.link.raw_frames`)."""
    precision: str = "float32"
    """"float64" runs the same kernels in double precision, for error budgets only."""

    @property
    def steps_per_output(self) -> int:
        """Strapdown steps from one solution to the next."""
        return max(1, (10 if self.strapdown == "mean" else self.imu_rate_hz) // self.output_rate_hz)

    @classmethod
    def of(cls, profile: Mapping[str, Any]) -> Settings:
        """Settings from a profile table. Raises ValueError for what no program could mean."""
        check_keys(
            profile, {field.name for field in fields(cls)}, dict.fromkeys(ANGLES_DEG, _check_angle), CHOICES
        )
        settings = cls(**profile)
        settings._check_together()
        return settings

    def _check_together(self) -> None:
        """Settings that are possible each, but not side by side."""
        if (self.acquisition == "timer") != (self.strapdown == "mean"):
            raise ValueError(
                f"acquisition = {self.acquisition!r} does not go with strapdown = {self.strapdown!r}; "
                'possible: "timer" with "mean", "data-ready" with "two-sample"'
            )
        if self.strapdown == "mean" and self.output_rate_hz > 10:
            raise ValueError(
                f"output_rate_hz = {self.output_rate_hz}: strapdown = 'mean' makes ten solutions a second"
            )
        if self.receiver == "nmea-default" and self.gnss_rate_hz != 1:
            raise ValueError(
                f"gnss_rate_hz = {self.gnss_rate_hz}: receiver = 'nmea-default' leaves it at 1 Hz; "
                "another rate needs receiver = 'nav-pvt'"
            )


def _check_angle(key: str, value: Any) -> None:
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 <= value < 360.0:
        raise ValueError(f"profile key {key} = {value!r} is no angle from 0 to below 360; for example 62.0")
