"""Draws error-models.png: what each error model does, by the simulator itself. Needs matplotlib.

python docs/images/error_models.py
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from host.sim.scenario.load import scenario_from
from host.sim.world import World

SECOND = 1_000_000_000
PLACE = {"latitude_deg": 30.5, "longitude_deg": 114.3}
TABLE = [{"kind": "rest", "duration_s": 40.0, "roll_rate_dps": 9.0}]
SWING = [
    {"kind": "rest", "duration_s": 10.0},
    {"kind": "weave", "duration_s": 60.0, "amplitude_dps": 90.0, "period_s": 6.0},
]
SINES: dict[str, dict[str, Any]] = {
    "white noise": {"noise_dps_per_rthz": 0.01},
    "constant: turn-on bias": {"turn_on_bias_dps": 0.3},
    "random walk": {"random_walk_dph_per_rts": 30.0},
    "Gauss-Markov, T = 60 s": {"instability_dph": 300.0, "instability_time_s": 60.0},
    "temperature: 10 K warm-up": {"bias_temperature_dps_per_k": 0.05},
}
MOVING: dict[str, dict[str, Any]] = {
    "scale 1 %": {"scale_percent": 1.0},
    "scale, Gauss-Markov 1 %": {"scale_instability_ppm": 10_000.0, "scale_instability_time_s": 30.0},
    "misalignment 1°": {"misalignment_deg": 1.0},
    "non-linearity 0.5 % of 100 °/s": {"nonlinearity_percent": 0.5, "nonlinearity_range_dps": 100.0},
    "range 60 °/s": {"range_dps": 60.0},
    "resolution 10 °/s": {"resolution_dps": 10.0},
    "bandwidth 0.3 Hz": {"bandwidth_hz": 0.3},
}


def world(seed: int = 1, **tables: Any) -> World:
    """A scenario of a few tables."""
    data = {"place": PLACE, "duration_s": 600.0, **tables}
    return World(scenario_from(data, "picture", "picture"), seed)


def gyro(errors: dict[str, Any], times_ns: Any, seed: int = 1, **more: Any) -> Any:
    """Rates of a gyro, °/s (n, 3)."""
    imu = {"preset": "perfect", "gyro": errors, "temperature": {"rise_k": 10.0, "rise_time_s": 120.0}}
    return np.degrees(world(seed, imu=imu, **more).imu("imu").sample(times_ns, 25.0)[:, 3:6])


def draw() -> None:
    """All panels."""
    figure, panels = plt.subplots(4, 5, figsize=(17, 12))
    places = iter(panels.ravel())
    rest_ns = np.arange(0, 600 * SECOND, SECOND // 10)
    for title, errors in SINES.items():
        panel = next(places)
        for seed in (1, 2, 3):
            panel.plot(rest_ns / SECOND, gyro(errors, rest_ns, seed)[:, 0], lw=0.7)
        panel.set(title=title, ylabel="gyro x at rest, °/s")
    moving_ns = np.arange(10 * SECOND, 25 * SECOND, SECOND // 50)
    true = gyro({}, moving_ns, segment=SWING)
    for title, errors in MOVING.items():
        panel = next(places)
        felt = gyro(errors, moving_ns, segment=SWING)
        shown = title.startswith(("range", "resolution", "bandwidth"))
        axis = 0 if title.startswith("mis") else 2
        panel.plot(moving_ns / SECOND, true[:, 2] if shown else (felt - true)[:, axis], lw=1)
        if shown:
            panel.plot(moving_ns / SECOND, felt[:, 2], lw=1)
        panel.set(title=title, ylabel="rate, °/s" if shown else f"error of gyro {'xyz'[axis]}, °/s")
    draw_table(next(places))
    draw_receiver(next(places), next(places))
    draw_ambient(next(places), next(places), next(places))
    for panel in panels.ravel():
        panel.grid(alpha=0.3)
        if not panel.lines:
            panel.axis("off")
    figure.tight_layout()
    figure.savefig(Path(__file__).with_name("error-models.png"), dpi=70)


def draw_table(panel: Any) -> None:
    """g-sensitivity on a table that rolls over."""
    times_ns = np.arange(0, 40 * SECOND, SECOND // 10)
    felt = gyro({"g_sensitivity_dps_per_g": 0.1}, times_ns, segment=TABLE) - gyro({}, times_ns, segment=TABLE)
    panel.plot(times_ns / SECOND, felt)
    panel.set(title="g-sensitivity, rolling over", ylabel="error of gyros, °/s")


def draw_receiver(position: Any, baseline: Any) -> None:
    """Errors of a receiver with two antennas, over an outage."""
    cut = world(outage=[{"start_s": 200.0, "duration_s": 60.0}])
    receiver = cut.gnss("gnss", None, np.array([1.0, 0.0, 0.0]))
    epochs = [receiver.epoch(k * SECOND) for k in range(600)]
    north = [(e.latitude - np.radians(30.5)) * 6.36e6 if e.fix else np.nan for e in epochs]
    position.plot(north, ".", ms=2)
    position.set(title="receiver: white, Gauss-Markov, outage", ylabel="north, m")
    solutions = [e.baseline for e in epochs]
    headings = [
        (np.degrees(s.heading) + 180) % 360 - 180 if s and s.fix != "NONE" else np.nan for s in solutions
    ]
    baseline.plot(headings, ".", ms=2)
    baseline.set(title="baseline of 1 m: float after an outage", ylabel="heading error, °")


def draw_ambient(iron: Any, pressure: Any, latency: Any) -> None:
    """Hard and soft iron over a circle, drift of a barometer, latencies of runs."""
    circle = [{"kind": "circle", "duration_s": 60.0, "rate_dps": 6.0}]
    times_ns = np.arange(1, 600) * SECOND // 10
    bent = {
        "hard_iron_ut": [8.0, -5.0, 0.0],
        "soft_iron": [[1.2, 0.1, 0.0], [0.1, 0.9, 0.0], [0.0, 0.0, 1.0]],
    }
    for errors in ({}, bent):
        field = world(segment=circle, duration_s=60.0, magnetometer=errors).compass("mag").sample(times_ns)
        iron.plot(field[:, 3] * 1e6, field[:, 4] * 1e6, lw=1)
    iron.set(title="hard and soft iron, a full turn", ylabel="field y over x, µT", aspect="equal")
    slow_ns = np.arange(1, 600) * SECOND
    for seed in (1, 2, 3):
        errors = {"drift_pa": 30.0, "drift_time_s": 120.0, "noise_pa": 2.0}
        felt = world(seed, barometer=errors).ten_dof("baro", preset="perfect").sample(slow_ns, 25.0)
        pressure.plot(slow_ns / SECOND, felt[:, 10] / 100.0, lw=0.7)
    pressure.set(title="barometer: drift, noise", ylabel="hPa")
    drawn = [world(seed).gnss("gnss").epoch(0).latency_ns / 1e6 for seed in range(60)]
    latency.hist(drawn, bins=12)
    latency.plot([], [])
    latency.set(title="receiver: latency of 60 runs", ylabel="runs over ms")


if __name__ == "__main__":
    draw()
