"""The closed loop of source 002, section 4.3: increments of a trajectory's points, integrated alone again."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from host.sim.scenario.schema import Scenario
from host.simulate.convention import Convention
from host.simulate.inverse import Closure, Inverse
from host.simulate.proof.figure import Figure
from host.simulate.proof.scenes import DOCUMENT_M, SCENES, scenario_of, wanted_motion
from host.simulate.sensors import TrackSensors

RATE_HZ = 200
LIMITS = (("position", "m", 1e-5), ("velocity", "m/s", 1e-6), ("attitude", "°", 1e-7))
NAMES = {"position": "position_rms_m", "velocity": "velocity_rms_mps", "attitude": "attitude_rms_deg"}


def inverse_of(scenario: Scenario, rate_hz: int) -> Inverse:
    """The closed loop along a scene."""
    motion = wanted_motion(scenario, rate_hz)
    sensors = TrackSensors(scenario, 1, motion, scenario.start.gps_time_ns)
    return Inverse(motion, Fraction(rate_hz), Convention.INCREMENT, scenario.start.gps_time_ns, sensors)


def figures() -> Iterator[Figure]:
    """Each scene: position, velocity and attitude RMS."""
    for name in SCENES:
        closure = Closure()
        for _ in inverse_of(scenario_of(name), RATE_HZ).blocks(closure):
            pass
        found = closure.figures()
        for quantity, unit, limit in LIMITS:
            document = f"{DOCUMENT_M[name]:.4f}" if quantity == "position" else "≤ 0.0001"
            yield Figure(
                "closure", f"{name}: {quantity} RMS", unit, found[NAMES[quantity]], document, most=limit
            )
