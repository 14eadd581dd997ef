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

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline, make_interp_spline, make_smoothing_spline

from host.sim.earth import E2, SEMI_MAJOR, radians_per_metre
from host.simulate.path_attitude import Attitude, LedAttitude, SplinedAttitude, constant, led, through
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
        self._attitude: Attitude = (
            self._given_attitude() if track.attitude is not None else self._attitude_of_motion(bank)
        )

    def offsets(self) -> Floats:
        """How far the motion passes from each point, m (n,)."""
        there = np.column_stack([spline(self._track.t_s) for spline in self._place])
        distance: Floats = np.linalg.norm(there - self._points, axis=1)
        return distance

    def states(self, t_s: Floats) -> Floats:
        """Rows (n, 10): latitude, longitude, height, v_n, q_nb."""
        north, east, height = (spline(t_s) for spline in self._place)
        place = (self._origin[0] + north * self._per_north, self._origin[1] + east * self._per_east, height)
        return np.column_stack((*place, self._velocities(t_s), self._attitude.quaternions(t_s)))

    def turning(self, t_s: Floats) -> Floats:
        """ω_nb in body axes (n, 3)."""
        return self._attitude.turning(t_s)

    def _velocities(self, t_s: Floats) -> Floats:
        if self._velocity is not None:
            return np.column_stack([spline(t_s) for spline in self._velocity])
        north, east, up = (slope(t_s) for slope in self._slope)
        latitude = self._origin[0] + self._place[0](t_s) * self._per_north
        height = self._place[2](t_s)
        m_here, e_here = metres_per_radian(latitude, height)
        return np.column_stack((north * self._per_north * m_here, east * self._per_east * e_here, -up))

    def _given_attitude(self) -> Attitude:
        assert self._track.attitude is not None
        return SplinedAttitude(self._track.t_s, self._track.attitude)

    def _attitude_of_motion(self, bank: bool) -> Attitude:
        count = max(2, math.ceil(self.end_s / ATTITUDE_STEP_S) + 1)
        t = np.linspace(0.0, self.end_s, count)
        v = self._velocities(t)
        level = np.hypot(v[:, 0], v[:, 1])
        moving = level > MOVING_MPS
        if not moving.any():
            return LedAttitude(constant, constant, constant)
        yaw = led(t[moving], np.unwrap(np.arctan2(v[moving, 1], v[moving, 0])), self.end_s)
        pitch = led(t[moving], np.arctan2(-v[moving, 2], level[moving]), self.end_s)
        if not bank:
            return LedAttitude(yaw, pitch, constant)
        lean = np.arctan(level * np.gradient(yaw(t), t) / GRAVITY)
        roll = led(t, np.clip(lean, -LARGEST_BANK, LARGEST_BANK), self.end_s)
        return LedAttitude(yaw, pitch, roll)


def _spline(t: Floats, y: Floats, sigma: float) -> BSpline:
    if sigma == 0.0:
        return through(t, y)
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
