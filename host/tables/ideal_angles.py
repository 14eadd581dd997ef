"""Rows of the angle tables with exact rates at the kernel's door: errors of arithmetic and update alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from host.sim.scenario.schema import Scenario
from host.sim.simulated import SimulatedVehicle
from host.sim.trajectory.kinematics import FORCE, OMEGA_IB
from host.tables.angle_rows import IDEAL, AngleRow, scored
from host.tables.document import DocumentRow
from host.tables.kernel_door import compute, level_at
from host.tables.positions import HOLD_S, PLACE, position_scenario

Array = NDArray[np.float64]
STILL_S = 0.4
HALF_PERIOD_NS = 4_000_000


def ideal_row(document: DocumentRow, arithmetic: str, method: str = "rk4") -> AngleRow:
    """One position in one arithmetic."""
    scenario = position_scenario(document.axis, document.angle_deg, STILL_S)
    samples, times_ns, truth = _felt(scenario)
    config = level_at(float(np.radians(PLACE["latitude_deg"])), PLACE["height_m"], method)
    made = compute(arithmetic, config, samples)
    held = times_ns[2::2] > times_ns[-1] - round(HOLD_S * 1e9)
    return scored(document, (IDEAL, arithmetic, False), made.angles[held], truth[2::2][held])


def _felt(scenario: Scenario) -> tuple[Array, NDArray[np.int64], Array]:
    """Samples every half iteration, their times, and the true pitch, roll, yaw."""
    vehicle = SimulatedVehicle(scenario, seed=1)
    count = vehicle.duration_ns // (2 * HALF_PERIOD_NS)
    times_ns = HALF_PERIOD_NS * np.arange(2 * count + 1, dtype=np.int64)
    rows = vehicle.motion.rows(times_ns)
    samples = np.zeros((len(times_ns), 9))
    samples[:, 0:3] = rows[:, OMEGA_IB : OMEGA_IB + 3]
    samples[:, 3:6] = rows[:, FORCE : FORCE + 3]
    truth = vehicle.truth(times_ns)
    return samples, times_ns, np.column_stack((truth.pitch, truth.roll, truth.yaw))
