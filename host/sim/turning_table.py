"""A table that turns what is mounted on it: exact attitude, gravity and rate of the Earth at one place.

It rests in an attitude, turns from there about an axis of the body to another one, or spins about an axis and
stops. Angles are polynomials of time, so that rate and angular acceleration are exact:

    to another attitude   θ = Θ (10 x³ − 15 x⁴ + 6 x⁵)
    spin                  θ̇ = Ω (3 x² − 2 x³) up, then Ω, then down again

What it does is told while time goes on; it begins when nobody has asked for later instants yet.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from host.sim.earth import EARTH_RATE, gravity
from host.sim.trajectory.kinematics import (
    C_NB,
    FORCE,
    HEIGHT,
    LATITUDE,
    LONGITUDE,
    OMEGA_DOT,
    OMEGA_IB,
    ROW,
)

Array = NDArray[np.float64]
NS = 1e-9
RAMP_S = 0.6
"""Of a spin, from rest to its rate."""
FASTEST = math.radians(180.0)
"""On the average, from one attitude to another."""
LEAST_TURN_S = 0.5


@dataclass(frozen=True)
class Stage:
    """One turn about a fixed axis; before it and behind it the table rests."""

    start_ns: int
    end_ns: int
    c_nb: Array
    """(3, 3) when it begins."""
    axis: Array
    """(3,) of the body."""
    angle: float
    """rad, all of it."""
    rate: float = 0.0
    """rad/s of a spin, held between its ramps; 0: to another attitude."""

    def course(self, t: Array) -> tuple[Array, Array, Array]:
        """Angle, rate and acceleration at times since its start, s."""
        duration = (self.end_ns - self.start_ns) * NS
        t = np.clip(t, 0.0, duration)
        if self.rate:
            return self._spin(t, duration)
        x = t / duration
        a = self.angle
        return (
            a * x**3 * (10.0 - 15.0 * x + 6.0 * x * x),
            a / duration * 30.0 * x * x * (1.0 - x) ** 2,
            a / duration**2 * 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x),
        )

    def _spin(self, t: Array, duration: float) -> tuple[Array, Array, Array]:
        up = np.clip(t / RAMP_S, 0.0, 1.0)
        down = np.clip((duration - t) / RAMP_S, 0.0, 1.0)
        held = np.clip(t - RAMP_S, 0.0, duration - 2.0 * RAMP_S)
        ramped = RAMP_S * (up**3 - up**4 / 2.0 + 0.5 - (down**3 - down**4 / 2.0))
        slope = (6.0 * (up - up * up) - 6.0 * (down - down * down)) / RAMP_S
        rate = np.minimum(up * up * (3.0 - 2.0 * up), down * down * (3.0 - 2.0 * down))
        return self.rate * (ramped + held), self.rate * rate, self.rate * slope


class TurningTable:
    """Its motion, as `host.sim.errors.inertial_sensor.Course`."""

    def __init__(self, latitude: float, longitude: float, height: float, c_nb: Array) -> None:
        """Place in rad and m, and the attitude in which it rests at first."""
        self._place = latitude, longitude, height
        self._gravity = gravity(math.sin(latitude), height)
        self._earth = EARTH_RATE * np.array((math.cos(latitude), 0.0, -math.sin(latitude)))
        self._stages = [Stage(-1, 0, np.array(c_nb, np.float64), np.array((0.0, 0.0, 1.0)), 0.0)]
        self._known_ns = 0
        """For instants up to here it has said where it is."""

    @property
    def rests_from_ns(self) -> int:
        """From when on it stands as it was told last."""
        return self._stages[-1].end_ns

    @property
    def attitude(self) -> Array:
        """C_n_b (3, 3) in which it will rest."""
        return _end_of(self._stages[-1])

    def turn_to(self, c_nb: Array, now_ns: int) -> None:
        """To another attitude, the short way."""
        here = self.attitude
        axis, angle = _axis_and_angle(here.T @ c_nb)
        start_ns = self._start(now_ns)
        took_s = max(LEAST_TURN_S, 2.0 * angle / FASTEST)
        stage = Stage(start_ns, start_ns + round(took_s / NS), here, axis, angle)
        self._stages.append(stage)

    def spin(self, axis: Array, rate: float, duration_s: float, now_ns: int) -> None:
        """About an axis of the body at `rate` rad/s for `duration_s`, ramps included; longer than both."""
        start_ns = self._start(now_ns)
        axis = np.asarray(axis, np.float64)
        angle = rate * (duration_s - RAMP_S)
        end_ns = start_ns + round(duration_s / NS)
        self._stages.append(Stage(start_ns, end_ns, self.attitude, axis, angle, rate))

    def _start(self, now_ns: int) -> int:
        return max(now_ns, self._known_ns, self.rests_from_ns) + 1

    def rows(self, times_ns: NDArray[np.int64]) -> Array:
        """Rows of truth (n, 24) at rising times."""
        times_ns = np.asarray(times_ns, np.int64)
        self._known_ns = max(self._known_ns, int(times_ns[-1]))
        return self._rows_at(times_ns)

    def looked_at(self, times_ns: NDArray[np.int64]) -> Array:
        """The same for somebody who does not mind that it changes: who looks ahead and comes again."""
        return self._rows_at(np.asarray(times_ns, np.int64))

    def _rows_at(self, times_ns: NDArray[np.int64]) -> Array:
        out = np.zeros((len(times_ns), ROW))
        out[:, LATITUDE], out[:, LONGITUDE], out[:, HEIGHT] = self._place
        starts = [stage.start_ns for stage in self._stages]
        which = np.searchsorted(starts, times_ns, side="right") - 1
        for number in np.unique(np.maximum(which, 0)).tolist():
            chosen = np.maximum(which, 0) == number
            stage = self._stages[number]
            out[chosen] = self._stage_rows(stage, (times_ns[chosen] - stage.start_ns) * NS, out[chosen])
        return out

    def _stage_rows(self, stage: Stage, t: Array, rows: Array) -> Array:
        angle, rate, acceleration = stage.course(t)
        c_nb = stage.c_nb @ _turns(stage.axis, angle)
        down = c_nb[:, 2, :]
        earth = np.einsum("kij,i->kj", c_nb, self._earth)
        turning = rate[:, None] * stage.axis
        rows[:, C_NB : C_NB + 9] = c_nb.reshape(-1, 9)
        rows[:, OMEGA_IB : OMEGA_IB + 3] = turning + earth
        rows[:, FORCE : FORCE + 3] = -self._gravity * down
        rows[:, OMEGA_DOT : OMEGA_DOT + 3] = acceleration[:, None] * stage.axis - np.cross(turning, earth)
        return rows


def _turns(axis: Array, angles: Array) -> Array:
    """(n, 3, 3) rotations about a unit axis (Rodrigues)."""
    x, y, z = axis
    k = np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))
    s, c = np.sin(angles)[:, None, None], np.cos(angles)[:, None, None]
    return np.eye(3) + s * k + (1.0 - c) * (k @ k)


def _end_of(stage: Stage) -> Array:
    return np.asarray(stage.c_nb @ _turns(stage.axis, np.array([stage.angle]))[0])


def _axis_and_angle(rotation: Array) -> tuple[Array, float]:
    """Of a rotation matrix; any axis where it is half a turn about several."""
    angle = math.acos(max(-1.0, min(1.0, (np.trace(rotation) - 1.0) / 2.0)))
    if angle > math.pi - 1e-6:
        values, vectors = np.linalg.eigh(rotation + rotation.T)
        return vectors[:, int(np.argmax(values))], math.pi
    if angle < 1e-9:
        return np.array((0.0, 0.0, 1.0)), 0.0
    skew = rotation - rotation.T
    axis = np.array((skew[2, 1], skew[0, 2], skew[1, 0]))
    return axis / np.linalg.norm(axis), angle
