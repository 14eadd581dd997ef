"""Attitude along a trajectory, and how fast it turns, at any instant.

Attitudes of a file are met by a spline of degree 5 through their quaternions, whose length does not matter:
with p such a spline, q = p / |p| and ω_nb = 2 vec(p⁻¹ ⊗ ṗ) in body axes. It goes through the vertical as
through any other attitude, where yaw and roll would jump.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline, PchipInterpolator, make_interp_spline

from host.simulate.attitude_forms import product, quaternions

Floats = NDArray[np.float64]
Angle = Callable[[Floats], Floats]


class Attitude(Protocol):
    """A body's attitude."""

    def quaternions(self, t_s: Floats) -> Floats:
        """q_nb (n, 4)."""
        ...

    def turning(self, t_s: Floats) -> Floats:
        """ω_nb in body axes (n, 3)."""
        ...


class SplinedAttitude:
    """Through given yaw, pitch, roll (n, 3)."""

    def __init__(self, t_s: Floats, angles: Floats) -> None:
        q = quaternions(angles)
        turns_over = np.einsum("ni,ni->n", q[1:], q[:-1]) < 0.0
        q[1:] *= np.where(np.cumsum(turns_over) % 2 == 1, -1.0, 1.0)[:, None]
        self._spline = through(t_s, q)
        self._slope = self._spline.derivative()

    def quaternions(self, t_s: Floats) -> Floats:
        """See Attitude."""
        p = self._spline(t_s)
        unit: Floats = p / np.linalg.norm(p, axis=1, keepdims=True)
        return unit

    def turning(self, t_s: Floats) -> Floats:
        """See Attitude."""
        p = self._spline(t_s)
        back = p * [1.0, -1.0, -1.0, -1.0] / (p**2).sum(axis=1, keepdims=True)
        return 2.0 * product(back, self._slope(t_s))[:, 1:]


@dataclass(frozen=True)
class LedAttitude:
    """By functions of yaw, pitch and roll."""

    yaw: Angle
    pitch: Angle
    roll: Angle

    def quaternions(self, t_s: Floats) -> Floats:
        """See Attitude."""
        return quaternions(np.column_stack((self.yaw(t_s), self.pitch(t_s), self.roll(t_s))))

    def turning(self, t_s: Floats) -> Floats:
        """See Attitude."""
        pitch, roll = self.pitch(t_s), self.roll(t_s)
        yaw_rate, pitch_rate, roll_rate = (_rate(one)(t_s) for one in (self.yaw, self.pitch, self.roll))
        level = yaw_rate * np.cos(pitch)
        return np.column_stack(
            (
                roll_rate - yaw_rate * np.sin(pitch),
                pitch_rate * np.cos(roll) + level * np.sin(roll),
                level * np.cos(roll) - pitch_rate * np.sin(roll),
            )
        )


def constant(t_s: Floats) -> Floats:
    """An angle that stays 0."""
    return np.zeros(len(t_s))


def led(t: Floats, angle: Floats, end_s: float) -> Angle:
    """Smoothly from value to value; before the first and after the last one it stays."""
    times, values = t, angle
    if t[0] > 0.0:
        times, values = np.concatenate(([0.0], times)), np.concatenate((values[:1], values))
    if times[-1] < end_s:
        times, values = np.concatenate((times, [end_s])), np.concatenate((values, values[-1:]))
    if len(times) == 1:
        return lambda t_s: np.full(len(t_s), values[0])
    led: Angle = PchipInterpolator(times, values)
    return led


def through(t: Floats, y: Floats) -> BSpline:
    """The spline that meets all values; of degree 5 where there are enough."""
    return make_interp_spline(t, y, k=5 if len(t) > 5 else 3)


def _rate(angle: Angle) -> Angle:
    """The derivative; what is no spline is constant."""
    return angle.derivative() if isinstance(angle, BSpline | PchipInterpolator) else constant
