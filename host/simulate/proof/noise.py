"""Set noise is found again by allantools: source 002, section 4.4, tables 4-4 to 4-9."""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from host.sim.earth import radians_per_metre
from host.sim.scenario.load import scenario_from
from host.sim.scenario.schema import Scenario
from host.sim.simulated import SimulatedVehicle
from host.simulate.allan import curve_of, identified
from host.simulate.proof.figure import Figure
from host.simulate.proof.scenes import PLACE
from host.simulate.stream import Drive, Request

Floats = NDArray[np.float64]
RATE_HZ, HALF_HOUR_S = 100, 1800.0
ROOT_HOUR = 60.0
DEG = math.pi / 180.0
GRADES = {"pos830": (0.0022, 0.00075), "stim300": (0.15, 0.07), "adis16488": (0.26, 0.029)}
"""°/√h and m/s/√h, table 4-10."""
SEEDS = 20
LONG_S, LONG_STEP_NS = 162_000.0, 10_000_000_000
KNOWN_FROM_S = 200.0
"""Instants every 10 s are no means over 10 s: the curve is the process's own from here on."""
INSTABILITIES = (("gyro", 0.5, "°/h", DEG / 3600.0, "39 %"), ("accelerometer", 50.0, "mGal", 1e-5, "47 %"))
RECEIVER = {"position": 0.3, "velocity": 0.5}
"""White noise, m and m/s: the middle grade of tables 4-8 and 4-9."""


def rest(duration_s: float, **tables: Any) -> Scenario:
    """Standing for so long."""
    return scenario_from({"place": PLACE, "duration_s": duration_s, **tables}, "rest", "rest")


def figures() -> Iterator[Figure]:
    """Random walks of three grades, Gauss–Markov biases of twenty seeds, white noise of a receiver."""
    for grade, (angle, velocity) in GRADES.items():
        off = _random_walks_off(grade, angle, velocity)
        yield Figure("noise", f"{grade}: angular random walk off", "%", off[0], "2.5", most=2.0)
        yield Figure("noise", f"{grade}: velocity random walk off", "%", off[1], "2.7", most=2.0)
    for kind, (off_percent, inside) in _markov_off().items():
        document = next(one[4] for one in INSTABILITIES if one[0] == kind)
        words = f"{kind} instability, {SEEDS} seeds of 45 h"
        yield Figure("noise", f"{words}: off", "%", off_percent, document.rstrip(" %"), most=5.0)
        yield Figure("noise", f"{words}: axes inside 95 %", "%", inside, least=85.0)
    for name, off_percent in _receiver_off().items():
        yield Figure("noise", f"receiver, white noise of {name} off", "%", off_percent, "4", most=4.0)


def _random_walks_off(grade: str, angle: float, velocity: float) -> tuple[float, float]:
    """The worst axis, %."""
    scenario = rest(HALF_HOUR_S, imu={"preset": grade})
    drive = Drive(Request(scenario, rate_hz=Fraction(RATE_HZ), gnss_rate_hz=Fraction(0)))
    felt = np.vstack([block.felt for block in drive.blocks()])
    found = [curve_of("axis", felt[:, k], RATE_HZ).coefficients.random_walk * ROOT_HOUR for k in range(6)]
    gyro = max(abs(one / DEG / angle - 1.0) for one in found[3:])
    return 100.0 * gyro, 100.0 * max(abs(one / velocity - 1.0) for one in found[:3])


def _markov_off() -> dict[str, tuple[float, float]]:
    """By sensor: how far the σ found in the mean of all seeds is off, and how many of the axes' own variances
    lie where 95 % of them should."""
    times_ns = np.arange(int(LONG_S * 1e9) // LONG_STEP_NS) * LONG_STEP_NS
    variances: dict[str, list[Floats]] = {kind: [] for kind, *_ in INSTABILITIES}
    slow: dict[str, list[Floats]] = {kind: [] for kind, *_ in INSTABILITIES}
    tau = np.zeros(0)
    for seed in range(1, SEEDS + 1):
        vehicle = SimulatedVehicle(rest(LONG_S, imu={"preset": "stim300"}), seed)
        errors = vehicle.imu("imu", np.eye(3), np.zeros(3)).slow_errors(times_ns)
        for k, (kind, *_) in enumerate(INSTABILITIES):
            for axis in range(3):
                curve = curve_of(kind, errors[:, 3 * k + axis], 1e9 / LONG_STEP_NS)
                tau = curve.tau_s
                variances[kind].append(curve.deviation**2)
                slow[kind].append(errors[:, 3 * k + axis])
    known = tau >= KNOWN_FROM_S
    found = {}
    for kind, sigma, _, unit, _ in INSTABILITIES:
        deviation = np.sqrt(np.mean(variances[kind], axis=0))
        fitted, _ = identified(tau[known], deviation[known], LONG_S)
        off = 100.0 * abs(fitted.markov / (sigma * unit) - 1.0)
        found[kind] = off, 100.0 * inside_share(np.array(slow[kind]), sigma * unit, 3600.0)
    return found


def inside_share(runs: Floats, sigma: float, time_s: float) -> float:
    """Share of Gauss–Markov runs (m, n), 10 s apart, whose innovations over `KNOWN_FROM_S` have a variance
    inside its 95 % interval: x(k+1) − a x(k) is white with σ² (1 − a²), and n of them are χ² with n degrees
    of freedom."""
    from scipy.stats import chi2

    runs = runs[:, :: round(KNOWN_FROM_S * 1e9 / LONG_STEP_NS)]
    keep = math.exp(-KNOWN_FROM_S / time_s)
    innovations = runs[:, 1:] - keep * runs[:, :-1]
    count = innovations.shape[1]
    scaled = np.sum(innovations**2, axis=1) / (sigma**2 * (1.0 - keep**2))
    low, high = chi2.ppf([0.025, 0.975], count)
    return float(np.mean((scaled >= low) & (scaled <= high)))


def _receiver_off() -> dict[str, float]:
    """White noise as the Allan deviation at one epoch, of three hours."""
    gnss = {"position_white_m": RECEIVER["position"], "position_markov_m": 0.0}
    gnss["velocity_white_mps"] = RECEIVER["velocity"]
    drive = Drive(Request(rest(10_800.0, gnss=gnss)))
    epochs = [epoch for _, epoch in drive.receiver_epochs()]
    per_m, _ = radians_per_metre(math.radians(PLACE["latitude_deg"]), PLACE["height_m"])
    north = np.array([epoch.latitude - epochs[0].latitude for epoch in epochs]) / per_m
    east_mps = np.array([epoch.velocity_ned[1] for epoch in epochs])
    found = {}
    for (name, value), series in zip(RECEIVER.items(), (north, east_mps), strict=True):
        deviation = float(curve_of(name, series, 1.0).deviation[0])
        found[name] = 100.0 * abs(deviation / value - 1.0)
    return found
