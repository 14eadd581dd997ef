"""Joints of the TOML form: nothing steps, and the jerk stays within what its flanks allow."""

from __future__ import annotations

from collections.abc import Iterator

from host.sim.simulated import SimulatedVehicle
from host.sim.trajectory.joints import Joints, examine
from host.simulate.proof.figure import Figure
from host.simulate.proof.noise import rest
from host.simulate.proof.scenes import scenario_of

BLEND_S = 0.5
STEEPEST = 1.875
"""Of the quintic flank."""
ACCELERATION, LENGTH_S = 1.5, 5.0


def figures() -> Iterator[Figure]:
    """The car's drive, whose segments are joined by flanks, and one flank for its jerk."""
    car = examine(SimulatedVehicle(scenario_of("car"), 1).motion.channels)
    smooth = "smooth"
    yield Figure(
        "joints", "car: steps of acceleration or turn rate", "", float(len(car.steps)), smooth, most=0.0
    )
    yield Figure(
        "joints", "car: largest step of speed or an angle", "", car.largest_value_step, smooth, most=1e-8
    )
    bound = STEEPEST * ACCELERATION * LENGTH_S / (LENGTH_S - BLEND_S) / BLEND_S
    jerk = _speeding_up().largest_jerk_mps3
    yield Figure(
        "joints", f"{ACCELERATION:g} m/s²: jerk over its stated bound", "", jerk / bound, most=1.0 + 1e-9
    )


def _speeding_up() -> Joints:
    segment = {"kind": "accelerate", "duration_s": LENGTH_S, "acceleration_mps2": ACCELERATION}
    scenario = rest(LENGTH_S, segment=[segment], trajectory={"blend_s": BLEND_S})
    return examine(SimulatedVehicle(scenario, 1).motion.channels)
