"""What a tilt-compensated compass feels at the vehicle's origin: force and the field on board.

Field: the World Magnetic Model of the run's start, bent by the vehicle's iron (`host.sim.vehicle_field`).
Force: gravity and the vehicle's acceleration, from its true velocity around each instant, ±0.05 s, about
what the part's own averaging leaves. Both in the chip's axes, with white noise of the part's repeatability:
0.3° of heading, 0.2° of tilt.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from host.sim.earth import radii_and_gravity
from host.sim.seeding import generator
from host.sim.truth import TruthBatch
from host.sim.vehicle_field import VehicleField, attitude_matrices

Array = NDArray[np.float64]

HALF_SPAN_NS = 50_000_000
FIELD_NOISE_T = 1.0e-7
"""0.3° of a horizontal field of 200 mgauss."""
FORCE_NOISE = 0.034
"""m/s²: 0.2° of tilt."""
TEMPERATURE_C = 25.0


class FeltCompass:
    """Implements `boards.chips.world.CompassWorld` on the truth of a drive."""

    def __init__(
        self,
        truth: Callable[[NDArray[np.int64]], TruthBatch],
        field: VehicleField,
        mounting: Array,
        seed: int,
        name: str,
    ) -> None:
        """`mounting` = C_b_s (3, 3): body = C_b_s sensor."""
        self._truth = truth
        self._field = field
        self._c_bs = np.asarray(mounting, dtype=np.float64)
        self._noise = generator(seed, f"{name}.compass.noise")

    def sample(self, times_ns: NDArray[np.int64]) -> Array:
        """Force (3), field (3), temperature at rising times."""
        here = self._truth(times_ns)
        noise = self._noise.standard_normal((len(times_ns), 6))
        values = np.empty((len(times_ns), 7))
        values[:, :3] = self._force(times_ns, here) @ self._c_bs + FORCE_NOISE * noise[:, :3]
        values[:, 3:6] = self._field.on_board(here) @ self._c_bs + FIELD_NOISE_T * noise[:, 3:]
        values[:, 6] = TEMPERATURE_C
        return values

    def _force(self, times_ns: NDArray[np.int64], here: TruthBatch) -> Array:
        """In body axes."""
        before, after = np.maximum(0, times_ns - HALF_SPAN_NS), times_ns + HALF_SPAN_NS
        gained = self._truth(after).v_ned - self._truth(before).v_ned
        force_n = gained / ((after - before)[:, None] * 1e-9)
        sines, heights = np.sin(here.latitude).tolist(), here.height.tolist()
        force_n[:, 2] -= [radii_and_gravity(s, h)[2] for s, h in zip(sines, heights, strict=True)]
        turned: Array = np.einsum("kij,ki->kj", attitude_matrices(here), force_n)
        return turned
