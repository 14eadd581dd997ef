"""Coning in closed form: an axis goes round a cone without turning about itself, yet gyros feel a mean rate.

    q_nb = (cos α/2, sin α/2 cos Ωt, sin α/2 sin Ωt, 0)
    ω_nb = (−Ω sin α sin Ωt, Ω sin α cos Ωt, −Ω (1 − cos α))   in body axes

An update that sums angles takes −Ω (1 − cos α) for a turn and drifts at it less what a whole iteration sees:

    (α²/2) Ω (1 − sin ΩT / ΩT)

(J. E. Bortz, A new mathematical formulation for strapdown inertial navigation, 1971).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firmware.nav.attitude.config import AttitudeConfig
from firmware.nav.attitude.flags import METHOD_NAMES
from host.sim.earth import EARTH_RATE, radii_and_gravity
from host.tables.angle_errors import rotation_between_quaternions
from host.tables.kernel_door import compute
from host.tables.positions import PLACE

Array = NDArray[np.float64]
METHODS = METHOD_NAMES
LATITUDE, HEIGHT = math.radians(PLACE["latitude_deg"]), PLACE["height_m"]


@dataclass(frozen=True, slots=True)
class Coning:
    """A cone of half angle `half_angle` (rad), gone round `frequency_hz` times a second, for `duration_s`."""

    half_angle: float = math.radians(1.0)
    frequency_hz: float = 10.0
    duration_s: float = 60.0
    period: float = 0.008
    """T of an iteration, s."""

    @property
    def drift_of_summed_angles(self) -> float:
        """rad over the whole time, of an update that knows no coning."""
        omega = 2.0 * math.pi * self.frequency_hz
        turn = omega * self.period
        return 0.5 * self.half_angle**2 * omega * (1.0 - math.sin(turn) / turn) * self.duration_s

    def attitude(self, times: Array) -> Array:
        """q_nb (n, 4) at times in s."""
        phase = 2.0 * math.pi * self.frequency_hz * times
        c, s = math.cos(0.5 * self.half_angle), math.sin(0.5 * self.half_angle)
        return np.column_stack((np.full(len(times), c), s * np.cos(phase), s * np.sin(phase), 0.0 * phase))

    def samples(self) -> Array:
        """ω_ib, f_b and no field (2 n + 1, 9) every half iteration, standing on the turning Earth."""
        count = 2 * round(self.duration_s / self.period) + 1
        times = 0.5 * self.period * np.arange(count, dtype=np.float64)
        omega = 2.0 * math.pi * self.frequency_hz
        around = omega * math.sin(self.half_angle)
        about = -omega * (1.0 - math.cos(self.half_angle))
        phase = omega * times
        felt = np.zeros((len(times), 9))
        felt[:, 0] = -around * np.sin(phase)
        felt[:, 1] = around * np.cos(phase)
        felt[:, 2] = about
        gravity = radii_and_gravity(math.sin(LATITUDE), HEIGHT)[2]
        earth = (EARTH_RATE * math.cos(LATITUDE), 0.0, -EARTH_RATE * math.sin(LATITUDE))
        to_body = _matrix(self.attitude(times)).transpose(0, 2, 1)
        felt[:, 0:3] += to_body @ np.array(earth)
        felt[:, 3:6] = to_body @ np.array((0.0, 0.0, -gravity))
        return felt


@dataclass(frozen=True, slots=True)
class ConingDrift:
    """Of one update in one arithmetic."""

    method: str
    arithmetic: str
    times_s: Array
    """Once a second."""
    error: Array
    """Total rotation against the closed form at these times, rad."""
    saturations: int

    @property
    def drift(self) -> float:
        """At the end, rad."""
        return float(self.error[-1])


def coning_drifts(
    coning: Coning, methods: tuple[str, ...], arithmetics: tuple[str, ...]
) -> Iterator[ConingDrift]:
    """Every method in every arithmetic."""
    samples = coning.samples()
    angle = coning.half_angle
    for method in methods:
        for arithmetic in arithmetics:
            config = AttitudeConfig(
                latitude=LATITUDE,
                height=HEIGHT,
                period=coning.period,
                method=method,
                attitude=(0.0, 0.0, angle),
            )
            made = compute(arithmetic, config, samples)
            times = coning.period * np.arange(1, len(made.q_nb) + 1, dtype=np.float64)
            error = rotation_between_quaternions(_unit(made.q_nb), coning.attitude(times))
            each = max(1, round(1.0 / coning.period))
            yield ConingDrift(
                method, arithmetic, times[each - 1 :: each], error[each - 1 :: each], made.saturations
            )


def _unit(q: Array) -> Array:
    return np.asarray(q / np.linalg.norm(q, axis=1)[:, None], np.float64)


def _matrix(q: Array) -> Array:
    """C_n_b (n, 3, 3)."""
    w, x, y, z = q.T
    rows = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )
    return np.array([[np.broadcast_to(v, w.shape) for v in row] for row in rows]).transpose(2, 0, 1)
