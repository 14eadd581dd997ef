"""The six scenes of the document's closed loop, twenty minutes each where the motion lasts so long."""

from __future__ import annotations

import tomllib
from typing import Any

import numpy as np

from boards.places import board_folder
from host.sim.scenario.load import scenario_from
from host.sim.scenario.schema import Scenario
from host.sim.simulated import SimulatedVehicle
from host.simulate.flyable import Flyable
from host.simulate.tracks.track import Track

NS = 1_000_000_000
MINUTES_S = 1200.0
PLACE = {"latitude_deg": 30.5278, "longitude_deg": 114.3557, "height_m": 20.0}
_BASIC = [
    [1, 20],
    [3, 10, 12, 0],
    [7, 8, 0, 90],
    [4, 5, 1.0, 0],
    [10, 5, 0, 10],
    [5, 12, 1, 4],
    [9, 12, 6, 10],
]
_BASIC += [[91, 6, 6, 5], [8, 12, 15, 0], [6, 4, 0, -1], [2, 5, -4, 0], [3, 21, 0, 0]]
CAR = board_folder("car_mems") / "scenarios" / "town-open.toml"
_SMOOTH: dict[str, Any] = {"vibration": {}, "sway": {}}


def _town() -> dict[str, Any]:
    """Twenty minutes through a town, as a scenario's file has them."""
    told = tomllib.loads(CAR.read_text(encoding="utf-8"))
    wanted = ("segment", "place", "initial", "vibration", "sway", "duration_s", "trajectory")
    return {key: told[key] for key in wanted if key in told}


SCENES: dict[str, dict[str, Any]] = {
    "rest": {"segment": [{"kind": "rest", "duration_s": MINUTES_S}]},
    "basic motion": {"trajectory": {"matrix": _BASIC * 10}},
    "car": {**_town(), **_SMOOTH},
    "car, shaken": _town(),
    "ship": {"segment": [{"kind": "ship", "duration_s": MINUTES_S}], "initial": {"speed_mps": 6.0}},
    "aircraft": {"segment": [{"kind": "aircraft", "duration_s": MINUTES_S, "speed_mps": 60.0}]},
    "shell": {"segment": [{"kind": "shell"}]},
}
DOCUMENT_M = {
    "rest": 0.0003,
    "basic motion": 0.0015,
    "car": 0.0022,
    "car, shaken": 0.0022,
    "ship": 0.0003,
    "aircraft": 0.0005,
    "shell": 0.0,
}
"""Position RMS, table 4-2, as printed."""


def scenario_of(name: str, **more: Any) -> Scenario:
    """A scene with sensors that have no errors."""
    tables = {"place": PLACE, "imu": {"preset": "perfect"}, **SCENES[name], **more}
    return scenario_from(tables, name.replace(" ", "-"), name)


def track_of(vehicle: SimulatedVehicle, rate_hz: int) -> Track:
    """The truth of a vehicle as points at a rate."""
    times_ns = np.arange(vehicle.duration_ns * rate_hz // NS + 1) * (NS // rate_hz)
    truth = vehicle.truth(times_ns)
    attitude = np.column_stack((truth.yaw, truth.pitch, truth.roll))
    place = truth.latitude, truth.longitude, truth.height
    return Track(times_ns / NS, *place, truth.v_ned, attitude)


def wanted_motion(scenario: Scenario, rate_hz: int) -> Flyable:
    """A scene as the motion along its points."""
    return Flyable(track_of(SimulatedVehicle(scenario, 1), rate_hz), 0.0)
