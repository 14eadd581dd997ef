"""What an inertial sample stands for."""

from __future__ import annotations

from enum import StrEnum


class Convention(StrEnum):
    """At its instant, the mean since the one before, or that mean times the time."""

    INSTANT = "instant"
    MEAN = "mean"
    INCREMENT = "increment"
