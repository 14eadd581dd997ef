"""From points of a trajectory to motion that a vehicle can make: position, velocity, attitude at any instant.

Positions are splines in metres north, east, up of the first point (scaled latitude and longitude, so that
nothing is lost). Points without noise are met by a spline of degree 5. Points of a receiver are smoothed by
the natural cubic spline that is as stiff as leaves them off by `sigma` (RMS an axis):

    min Σ (yᵢ − f(tᵢ))² + λ ∫ f''² dt

Velocity is its derivative unless the points have one. Where they have no attitude, the vehicle points along
its velocity: yaw = atan2(v_E, v_N), pitch = atan(−v_D / √(v_N² + v_E²)), both from instants with more than
`MOVING_MPS`, and held or led over the time without; roll is 0, or with `bank` atan(v ψ̇ / g).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline, PchipInterpolator, make_interp_spline, make_smoothing_spline

from host.sim.earth import E2, SEMI_MAJOR, radians_per_metre
from host.simulate.tracks.track import Track

Floats = NDArray[np.float64]

MOVING_MPS = 1.0
ATTITUDE_STEP_S = 0.25
"""Attitude is taken from the motion so often, and led smoothly in between."""
GRAVITY = 9.80665
LARGEST_BANK = math.radians(80.0)
VERTICAL = 2.0
"""Receivers know heights so much worse."""
HALVINGS = 40


class Flyable:
    """Motion along a track."""

    def __init__(self, track: Track, sigma_m: float, bank: bool = False) -> None:
        self._track = track
        t = track.t_s
        self.end_s = float(t[-1])
        self._origin = float(track.latitude[0]), float(track.longitude[0])
        self._per_north, self._per_east = radians_per_metre(self._origin[0], float(track.height[0]))
        self._points = np.column_stack(
            (
                (track.latitude - self._origin[0]) / self._per_north,
                (np.unwrap(track.longitude) - self._origin[1]) / self._per_east,
                track.height,
            )
        )
        sigmas = (sigma_m, sigma_m, VERTICAL * sigma_m)
        self._place = [_spline(t, y, s) for y, s in zip(self._points.T, sigmas, strict=True)]
        self._slope = [spline.derivative() for spline in self._place]
        self._velocity = None
        if track.velocity is not None and sigma_m == 0.0:
            self._velocity = [_spline(t, v, 0.0) for v in track.velocity.T]
        self._angles = self._given_angles() if track.attitude is not None else self._angles_of_motion(bank)
        self._angle_rates = [_rate(angle) for angle in self._angles]

    def offsets(self) -> Floats:
        """How far the motion passes from each point, m (n,)."""
        there = np.column_stack([spline(self._track.t_s) for spline in self._place])
        distance: Floats = np.linalg.norm(there - self._points, axis=1)
        return distance

    def motion(self, t_s: Floats) -> Floats:
        """Rows (n, 9): latitude, longitude, height, v_n, yaw, pitch, roll."""
        north, east, height = (spline(t_s) for spline in self._place)
        place = (self._origin[0] + north * self._per_north, self._origin[1] + east * self._per_east, height)
        return np.column_stack((*place, self._velocities(t_s), *(angle(t_s) for angle in self._angles)))

    def turning(self, t_s: Floats) -> Floats:
        """ω_nb in body axes (n, 3)."""
        _, pitch, roll = (angle(t_s) for angle in self._angles)
        yaw_rate, pitch_rate, roll_rate = (rate(t_s) for rate in self._angle_rates)
        level = yaw_rate * np.cos(pitch)
        return np.column_stack(
            (
                roll_rate - yaw_rate * np.sin(pitch),
                pitch_rate * np.cos(roll) + level * np.sin(roll),
                level * np.cos(roll) - pitch_rate * np.sin(roll),
            )
        )

    def _velocities(self, t_s: Floats) -> Floats:
        if self._velocity is not None:
            return np.column_stack([spline(t_s) for spline in self._velocity])
        north, east, up = (slope(t_s) for slope in self._slope)
        latitude = self._origin[0] + self._place[0](t_s) * self._per_north
        height = self._place[2](t_s)
        m_here, e_here = metres_per_radian(latitude, height)
        return np.column_stack((north * self._per_north * m_here, east * self._per_east * e_here, -up))

    def _given_angles(self) -> list[Callable[[Floats], Floats]]:
        assert self._track.attitude is not None
        return [_spline(self._track.t_s, np.unwrap(angle), 0.0) for angle in self._track.attitude.T]

    def _angles_of_motion(self, bank: bool) -> list[Callable[[Floats], Floats]]:
        count = max(2, math.ceil(self.end_s / ATTITUDE_STEP_S) + 1)
        t = np.linspace(0.0, self.end_s, count)
        v = self._velocities(t)
        level = np.hypot(v[:, 0], v[:, 1])
        moving = level > MOVING_MPS
        if not moving.any():
            return [_constant, _constant, _constant]
        yaw = _led(t[moving], np.unwrap(np.arctan2(v[moving, 1], v[moving, 0])), self.end_s)
        pitch = _led(t[moving], np.arctan2(-v[moving, 2], level[moving]), self.end_s)
        if not bank:
            return [yaw, pitch, _constant]
        lean = np.arctan(level * np.gradient(yaw(t), t) / GRAVITY)
        return [yaw, pitch, _led(t, np.clip(lean, -LARGEST_BANK, LARGEST_BANK), self.end_s)]


def _constant(t_s: Floats) -> Floats:
    return np.zeros(len(t_s))


def _led(t: Floats, angle: Floats, end_s: float) -> Callable[[Floats], Floats]:
    """Smoothly from value to value; before the first and after the last one it stays."""
    times, values = t, angle
    if t[0] > 0.0:
        times, values = np.concatenate(([0.0], times)), np.concatenate((values[:1], values))
    if times[-1] < end_s:
        times, values = np.concatenate((times, [end_s])), np.concatenate((values, values[-1:]))
    if len(times) == 1:
        return lambda t_s: np.full(len(t_s), values[0])
    led: Callable[[Floats], Floats] = PchipInterpolator(times, values)
    return led


def _rate(angle: Callable[[Floats], Floats]) -> Callable[[Floats], Floats]:
    """The derivative; what is no spline is constant."""
    return angle.derivative() if isinstance(angle, BSpline | PchipInterpolator) else _constant


def _spline(t: Floats, y: Floats, sigma: float) -> BSpline:
    if sigma == 0.0:
        return make_interp_spline(t, y, k=5 if len(t) > 5 else 3)
    if len(t) < 5:
        return make_interp_spline(t, y, k=3)
    low, high = -12.0, 16.0
    spline = make_smoothing_spline(t, y, lam=10.0**high)
    if _residual(spline, t, y) <= sigma:
        return spline
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        spline = make_smoothing_spline(t, y, lam=10.0**middle)
        if _residual(spline, t, y) > sigma:
            high = middle
        else:
            low = middle
        if high - low < 1e-3:
            break
    return make_smoothing_spline(t, y, lam=10.0**low)


def _residual(spline: BSpline, t: Floats, y: Floats) -> float:
    return float(np.sqrt(np.mean((spline(t) - y) ** 2)))


def metres_per_radian(latitude: Floats, height: Floats) -> tuple[Floats, Floats]:
    """M + h, and the radius of the parallel."""
    sin = np.sin(latitude)
    w2 = 1.0 - E2 * sin * sin
    n = SEMI_MAJOR / np.sqrt(w2)
    return n * (1.0 - E2) / w2 + height, (n + height) * np.cos(latitude)
