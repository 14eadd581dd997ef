"""What a tilt-compensated compass feels at the vehicle's origin: force and the field on board.

Field: the World Magnetic Model of the run's start, bent by the vehicle's iron (`host.sim.vehicle_field`).
Force: gravity and the vehicle's acceleration, from its true velocity around each instant, ±0.05 s, about
what the part's own averaging leaves. Both in the chip's axes, with white noise of the part's repeatability:
0.3° of heading, 0.2° of tilt. Or, where a scenario says so, with errors of the angles that come out instead:
force and field are then those of an attitude that is wrong by them.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from host.sim.earth import radii_and_gravity
from host.sim.errors.ambient_schema import CompassErrors
from host.sim.seeding import generator
from host.sim.truth import TruthBatch
from host.sim.vehicle_field import VehicleField, attitude_matrices, axes

Array = NDArray[np.float64]

HALF_SPAN_NS = 50_000_000
FIELD_NOISE_T = 1.0e-7
"""0.3° of a horizontal field of 200 mgauss."""
FORCE_NOISE = 0.034
"""m/s²: 0.2° of tilt."""
TEMPERATURE_C = 25.0


class WrongAngles:
    """Errors of pitch, roll and heading: white noise and a Gauss-Markov process. Times must rise."""

    def __init__(self, errors: CompassErrors, seed: int, name: str) -> None:
        self._white = np.radians(axes(errors.noise_deg))
        self._lasting: list[float] = np.radians(axes(errors.markov_deg)).tolist()
        self._rate = 1e-9 / errors.markov_time_s
        self._noise = generator(seed, f"{name}.compass.angles")
        begun = generator(seed, f"{name}.compass.begun").standard_normal(3)
        self._error: list[float] = (np.radians(axes(errors.initial_deg)) * begun).tolist()
        self._time_ns = 0

    def shown(self, truth: TruthBatch) -> TruthBatch:
        """The attitude that the compass is to show."""
        drawn = self._noise.standard_normal((len(truth.times_ns), 2, 3))
        lasting = [*map(self._later, truth.times_ns.tolist(), drawn[:, 0].tolist())]
        wrong = np.reshape(lasting, (-1, 3))
        wrong = wrong + self._white * drawn[:, 1]
        pitch, roll, yaw = truth.pitch + wrong[:, 0], truth.roll + wrong[:, 1], truth.yaw + wrong[:, 2]
        return replace(truth, pitch=pitch, roll=roll, yaw=yaw)

    def _later(self, time_ns: int, drawn: list[float]) -> list[float]:
        """What lasts of the errors at a time, three numbers drawn for the way there."""
        decay = math.exp(-self._rate * (time_ns - self._time_ns))
        grown = math.sqrt(1.0 - decay * decay)
        self._time_ns = time_ns
        self._error = [
            decay * error + lasting * grown * number
            for error, lasting, number in zip(self._error, self._lasting, drawn, strict=True)
        ]
        return self._error

    def noise(self) -> Any:
        """What the errors to come depend on."""
        return self._noise.bit_generator.state, self._error, self._time_ns

    def set_noise(self, noise: Any) -> None:
        """Go on from there."""
        self._noise.bit_generator.state, self._error, self._time_ns = noise


class FeltCompass:
    """Implements `boards.chips.world.CompassWorld` on the truth of a drive."""

    def __init__(
        self,
        truth: Callable[[NDArray[np.int64]], TruthBatch],
        field: VehicleField,
        mounting: Array,
        seed: int,
        name: str,
        errors: CompassErrors | None = None,
    ) -> None:
        """`mounting` = C_b_s (3, 3): body = C_b_s sensor. `errors` None: the part's noise."""
        self._truth = truth
        self._field = field
        self._c_bs = np.asarray(mounting, dtype=np.float64)
        self._noise = generator(seed, f"{name}.compass.noise")
        self._wrong = None if errors is None else WrongAngles(errors, seed, name)

    def sample(self, times_ns: NDArray[np.int64]) -> Array:
        """Force (3), field (3), temperature at rising times."""
        here = self._truth(times_ns)
        noise = np.zeros((len(times_ns), 6))
        if self._wrong is None:
            noise = self._noise.standard_normal((len(times_ns), 6))
        else:
            here = self._wrong.shown(here)
        values = np.empty((len(times_ns), 7))
        values[:, :3] = self._force(times_ns, here) @ self._c_bs + FORCE_NOISE * noise[:, :3]
        values[:, 3:6] = self._field.on_board(here) @ self._c_bs + FIELD_NOISE_T * noise[:, 3:]
        values[:, 6] = TEMPERATURE_C
        return values

    def noise(self) -> Any:
        """All sources of noise as they are now."""
        wrong = None if self._wrong is None else self._wrong.noise()
        return self._noise.bit_generator.state, wrong, [one.bit_generator.state for one in self._field.noise]

    def set_noise(self, noise: Any) -> None:
        """Draw from there on."""
        self._noise.bit_generator.state, wrong, field = noise
        if self._wrong is not None:
            self._wrong.set_noise(wrong)
        for one, state in zip(self._field.noise, field, strict=True):
            one.bit_generator.state = state

    def _force(self, times_ns: NDArray[np.int64], here: TruthBatch) -> Array:
        """In body axes."""
        before, after = np.maximum(0, times_ns - HALF_SPAN_NS), times_ns + HALF_SPAN_NS
        gained = self._truth(after).v_ned - self._truth(before).v_ned
        force_n = gained / ((after - before)[:, None] * 1e-9)
        sines, heights = np.sin(here.latitude).tolist(), here.height.tolist()
        force_n[:, 2] -= [radii_and_gravity(s, h)[2] for s, h in zip(sines, heights, strict=True)]
        turned: Array = np.einsum("kij,ki->kj", attitude_matrices(here), force_n)
        return turned
