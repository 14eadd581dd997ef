"""The motion of a rotary table: from level at 20 °/s to an angle about one axis, then five seconds of rest.

    θ(t) rises with ω₀ = 20 °/s; its flanks take BLEND_S each, in which the rate is a quintic,
    so that the way to the angle takes |θ| / ω₀ + BLEND_S

A table has no steps in its rate either; and with flanks the truth of every sample is exact in closed form.
"""

from __future__ import annotations

from typing import Any

from host.sim.scenario.load import scenario_from
from host.sim.scenario.motion_schema import ANGLE_BLEND_S
from host.sim.scenario.schema import Scenario

RATE_DPS = 20.0
HOLD_S = 5.0
STEEP_DEG = 80.0
"""From this pitch on yaw and roll are not told apart well: the total rotation is scored."""
PLACE = {"latitude_deg": 40.85, "longitude_deg": 111.70, "height_m": 1065.0, "geoid_separation_m": -15.0}
"""Hohhot, where the document was written."""
FAST_TURN_S = 1.0
"""How long the fast turn of the drift test takes; the document tells no rate."""


def position_scenario(axis: str, angle_deg: float, still_s: float, **tables: Any) -> Scenario:
    """`still_s` of rest, the turn about `axis` ("pitch", "roll", "yaw"), the hold.

    `tables`: what else would stand in the scenario's file. Raises ScenarioError.
    """
    motion: list[dict[str, Any]] = [{"kind": "rest", "duration_s": still_s}]
    if angle_deg:
        motion.append(_turn(axis, angle_deg, motion_s(angle_deg)))
    motion.append({"kind": "rest", "duration_s": HOLD_S})
    return _scenario(f"{axis} {angle_deg:+g}°", motion, tables)


def motion_s(angle_deg: float) -> float:
    """How long the table turns."""
    return abs(angle_deg) / RATE_DPS + ANGLE_BLEND_S if angle_deg else 0.0


def drift_scenario(yaw_deg: float, hold_s: float, still_s: float, **tables: Any) -> Scenario:
    """`still_s` of rest, a fast turn to a yaw, `hold_s` of rest. Raises ScenarioError."""
    motion = [
        {"kind": "rest", "duration_s": still_s},
        _turn("yaw", yaw_deg, FAST_TURN_S),
        {"kind": "rest", "duration_s": hold_s},
    ]
    return _scenario(f"fast turn to {yaw_deg:+g}°", motion, tables)


def _turn(axis: str, angle_deg: float, duration_s: float) -> dict[str, Any]:
    rate_dps = angle_deg / duration_s
    if axis == "yaw":
        return {"kind": "circle", "duration_s": duration_s, "rate_dps": rate_dps}
    return {"kind": "rest", "duration_s": duration_s, f"{axis}_rate_dps": rate_dps}


def _scenario(name: str, motion: list[dict[str, Any]], tables: dict[str, Any]) -> Scenario:
    data = {"place": PLACE, "trajectory": {"blend_s": ANGLE_BLEND_S}, "segment": motion, **tables}
    return scenario_from(data, name, name)
