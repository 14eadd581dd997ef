"""Draws motions.png: each kind of segment, by the simulator itself. Needs matplotlib.

python docs/images/motions.py
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from host.sim.scenario.load import scenario_from
from host.sim.simulated import SimulatedVehicle

SECOND = 1_000_000_000
PLACE = {"latitude_deg": 30.5, "longitude_deg": 114.3}
PATHS: dict[str, dict[str, Any]] = {
    "turn": {"duration_s": 10.0, "angle_deg": 90.0},
    "circle": {"duration_s": 35.0, "rate_dps": 9.0},
    "weave": {"duration_s": 24.0, "amplitude_dps": 15.0, "period_s": 6.0},
    "weave-cosine": {"duration_s": 24.0, "amplitude_dps": 15.0, "period_s": 6.0},
    "turn-rate-ramp": {"duration_s": 22.0, "from_dps": 0.0, "to_dps": 25.0},
    "s-curve": {"duration_s": 20.0, "angle_deg": 60.0},
    "l-shape": {"duration_s": 34.0},
    "cross": {"duration_s": 80.0},
    "figure-eight": {"duration_s": 60.0},
}
"""Driven at 10 m/s, seen from above."""
SPEEDS: dict[str, tuple[float, dict[str, Any]]] = {
    "rest": (0.0, {"duration_s": 10.0}),
    "cruise": (6.0, {"duration_s": 10.0, "pitch_to_deg": 4.0}),
    "speed-change": (6.0, {"duration_s": 10.0, "by_mps": 5.0}),
    "reach-speed": (6.0, {"duration_s": 10.0, "to_mps": 0.0}),
    "accelerate": (2.0, {"duration_s": 10.0, "acceleration_mps2": 1.0}),
    "surge": (6.0, {"duration_s": 12.0, "amplitude_mps2": 2.0, "period_s": 4.0}),
    "acceleration-ramp": (2.0, {"duration_s": 10.0, "from_mps2": 0.0, "to_mps2": 2.0}),
}
"""Speed at the beginning, keys; speed, and force along x."""
ANGLES: dict[str, tuple[float, dict[str, Any]]] = {
    "rotary-table": (0.0, {"dwell_s": 8.0, "move_s": 5.0}),
    "coning": (0.0, {"duration_s": 8.0, "half_angle_deg": 1.0, "frequency_hz": 1.0}),
    "sculling": (0.0, {"duration_s": 8.0, "amplitude_mps2": 5.0, "angle_deg": 1.0, "frequency_hz": 1.0}),
    "banked-turn": (30.0, {"duration_s": 30.0, "angle_deg": 90.0}),
    "ship": (6.0, {"duration_s": 90.0}),
}
"""Yaw, pitch and roll; of sculling also the force."""
HEIGHTS: dict[str, dict[str, Any]] = {"aircraft": {"duration_s": 600.0}, "shell": {}}
KINDS = (*PATHS, *SPEEDS, *ANGLES, *HEIGHTS)


def driven(kind: str, keys: dict[str, Any], speed_mps: float) -> tuple[Any, Any, Any]:
    """Times in s, truth, and rows of perfect sensors of one segment."""
    data = {"segment": [{"kind": kind, **keys}], "initial": {"speed_mps": speed_mps}, "place": PLACE}
    vehicle = SimulatedVehicle(scenario_from(data, "picture", "picture"), 1)
    times_ns = np.linspace(0, vehicle.duration_ns, 1500).astype(np.int64)
    return times_ns / SECOND, vehicle.truth(times_ns), vehicle.motion.rows(times_ns)


def metres(truth: Any) -> tuple[Any, Any]:
    """North and east of the first point."""
    north = (truth.latitude - truth.latitude[0]) * 6.35e6
    return north, (truth.longitude - truth.longitude[0]) * 6.38e6 * np.cos(truth.latitude[0])


def draw_path(panel: Any, kind: str) -> None:
    """From above."""
    north, east = metres(driven(kind, PATHS[kind], 10.0)[1])
    panel.plot(east, north, lw=2)
    panel.plot(0, 0, "o")
    panel.axis("equal")
    panel.set(title=kind, xlabel="east, m", ylabel="north, m")


def draw_speed(panel: Any, kind: str) -> None:
    """Speed, and what pushes along x."""
    speed_mps, keys = SPEEDS[kind]
    t, truth, rows = driven(kind, keys, speed_mps)
    panel.plot(t, np.linalg.norm(truth.v_ned, axis=1), lw=2, label="speed, m/s")
    panel.plot(t, rows[:, 18], lw=1, label="force x, m/s²")
    panel.legend(fontsize=8)
    panel.set(title=kind + (", pitch to 4°" if "pitch_to_deg" in keys else ""), xlabel="s")


def draw_angles(panel: Any, kind: str) -> None:
    """Yaw, pitch, roll."""
    speed_mps, keys = ANGLES[kind]
    t, truth, rows = driven(kind, keys, speed_mps)
    for name in ("yaw", "pitch", "roll"):
        angle = (np.degrees(getattr(truth, name)) + 180.0) % 360.0 - 180.0
        panel.plot(t, angle, lw=1.2, label=f"{name}, °")
    if kind == "sculling":
        panel.plot(t, rows[:, 18], lw=1.2, label="force x, m/s²")
    panel.legend(fontsize=8)
    panel.set(title=kind, xlabel="s")


def draw_height(panel: Any, kind: str) -> None:
    """Height over the way."""
    _, truth, _ = driven(kind, HEIGHTS[kind], 0.0)
    way = np.concatenate(([0.0], np.cumsum(np.hypot(*map(np.diff, metres(truth))))))
    panel.plot(way, truth.height - truth.height[0], lw=2)
    panel.set(title=kind, xlabel="way, m", ylabel="height, m")


def draw() -> None:
    """All panels."""
    figure, panels = plt.subplots(4, 6, figsize=(17, 11.5))
    for panel, kind in zip(panels.ravel(), KINDS, strict=False):
        for group, drawn in (
            (PATHS, draw_path),
            (SPEEDS, draw_speed),
            (ANGLES, draw_angles),
            (HEIGHTS, draw_height),
        ):
            if kind in group:
                drawn(panel, kind)
        panel.grid(alpha=0.3)
    for panel in panels.ravel()[len(KINDS) :]:
        panel.axis("off")
    figure.tight_layout()
    figure.savefig(Path(__file__).with_name("motions.png"), dpi=70)


if __name__ == "__main__":
    draw()
