"""What the sensor elements feel besides the motion of the part's origin.

Force acts on the gyros, Δω_i = k·f_i, and an accelerometer that sits at r_i feels

    Δf_i = [ω̇ × r_i + ω × (ω × r_i)]_i

unless bits 7 and 6 of MSC_CTRL have the part take that out. The sheet has no figures: k and r_i are
zero unless the board states them. ω̇ is the difference of neighbouring samples of the rate, with its noise.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from boards.chips.adis16407.settings import Conversion

Floats = NDArray[np.float64]
FORCE, RATE = slice(0, 3), slice(3, 6)
STANDARD_GRAVITY = 9.80665


@dataclass(frozen=True)
class Elements:
    """`g_effect_dps`: °/s a g on each gyro. `places_m`: of the x, y, z accelerometers, (3, 3)."""

    g_effect_dps: float = 0.0
    places_m: Floats = field(default_factory=lambda: np.zeros((3, 3)))

    def feel(self, motion: Floats, setting: Conversion, period_s: float) -> Floats:
        """The world's columns (n, 11) as the elements feel them, less what the part takes out; `period_s` of
        the samples, 0 when it is not known."""
        acts = self.g_effect_dps != 0.0 and not setting.compensated
        apart = bool(self.places_m.any()) and not setting.aligned
        if not len(motion) or not (acts or apart):
            return motion
        felt = motion.copy()
        if acts:
            felt[:, RATE] += np.radians(self.g_effect_dps) / STANDARD_GRAVITY * motion[:, FORCE]
        if apart:
            rate = motion[:, RATE]
            known = period_s > 0.0 and len(rate) > 1
            change = np.gradient(rate, period_s, axis=0) if known else np.zeros_like(rate)
            for axis, place in enumerate(self.places_m):
                turning = np.cross(change, place) + np.cross(rate, np.cross(rate, place))
                felt[:, axis] += turning[:, axis]
        return felt


def elements(name: str, g_effect_dps_per_g: float, places_mm: list[list[float]] | None) -> Elements:
    """From a board's parameters. Raises ValueError."""
    if not abs(g_effect_dps_per_g) <= 10.0:
        raise ValueError(f"{name}: g_effect_dps_per_g = {g_effect_dps_per_g}; within ±10, e.g. 0.05")
    places = np.zeros((3, 3)) if places_mm is None else np.array(places_mm, np.float64)
    if places.shape != (3, 3) or not (np.abs(places) <= 100.0).all():
        raise ValueError(
            f"{name}: accelerometer_places_mm = {places_mm}; a place within ±100 mm for each of x, y, z,"
            " e.g. [[3.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, -2.0]]"
        )
    return Elements(float(g_effect_dps_per_g), places * 1e-3)
