"""Drives of a tactical inertial unit (200 Hz) with a two-antenna receiver (1 Hz), as its board hears them.

Truth and error-free samples are the simulator's; the errors are drawn here, closed form and by seed: bias,
white noise; white plus first-order Gauss-Markov for position and heading; white for velocity.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from firmware.drivers import gnss_epoch as gnss
from host.sim.scenario.load import load_scenario
from host.sim.truth import TruthBatch
from host.sim.world import World

Array = NDArray[np.float64]
NS = 1_000_000_000
STEP_NS = 5_000_000
DEG = math.pi / 180.0
G = 9.80665
ANTENNA = (0.2, 0.1, -1.2)
BASELINE = (2.0, 0.0, 0.0)
ARRIVAL_NS = 150_000_000
"""From validity to the last byte."""
SCENARIOS = Path(__file__).parents[2] / "boards" / "car_mems" / "scenarios"
A, E2 = 6378137.0, 0.00669437999014


@dataclass(frozen=True)
class Errors:
    """1 σ; defaults are the board's document and its page."""

    gyro_bias: float = 0.1 * DEG / 3600.0
    angle_walk: float = 0.01 * DEG / 60.0
    accel_bias: float = 100e-6 * G
    velocity_walk: float = 0.01 / 60.0
    position_white: float = 1.5
    position_error: float = 1.5
    velocity: float = 0.1
    heading_white: float = 0.08 * DEG
    heading_error: float = 0.06 * DEG


@dataclass(frozen=True)
class Drive:
    """What was true, what the unit and the receiver told."""

    times_ns: NDArray[np.int64]
    samples: Array
    """(n, 6) rate, specific force, body axes."""
    epochs: tuple[NDArray[np.int64], ...]
    """Records in rising order of validity."""
    truth: TruthBatch
    """At full seconds."""
    receiver_error: Array
    """(m, 3) of its position, NED, m."""
    heading_error: Array
    """(m,) rad."""


@functools.cache
def ideal(
    scenario: str, duration_s: float, overrides: tuple[str, ...] = ()
) -> tuple[Array, TruthBatch, TruthBatch]:
    """Error-free samples, truth of the unit and of the antenna at full seconds."""
    changes = ("imu.preset=perfect", f"duration_s={duration_s}", *overrides)
    world = World(load_scenario(SCENARIOS / f"{scenario}.toml", changes), 1)
    sensor = world.imu("imu")
    times = np.arange(1, round(duration_s * NS) // STEP_NS, dtype=np.int64) * STEP_NS
    raw = np.concatenate([sensor.sample(times[k : k + 1000], 1000.0) for k in range(0, len(times), 1000)])
    seconds = np.arange(1, int(duration_s), dtype=np.int64) * NS
    return (
        np.hstack((raw[:, 3:6], raw[:, :3])),
        world.truth(seconds),
        world.antenna_truth(seconds, np.array(ANTENNA)),
    )


def make_drive(
    seed: int,
    scenario: str = "town-open",
    duration_s: float = 1200.0,
    errors: Errors = Errors(),
    overrides: tuple[str, ...] = (),
) -> Drive:
    """One draw of all errors on a drive."""
    clean, truth, antenna = ideal(scenario, duration_s, overrides)
    rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, 200])))
    dt = STEP_NS / NS
    n, m = len(clean), len(truth.times_ns)
    bias = np.concatenate((rng.normal(0, errors.gyro_bias, 3), rng.normal(0, errors.accel_bias, 3)))
    walk = np.repeat((errors.angle_walk, errors.velocity_walk), 3) / math.sqrt(dt)
    samples = clean + bias + rng.normal(0.0, 1.0, (n, 6)) * walk
    position = rng.normal(0, errors.position_white, (m, 3)) + markov(rng, m, 3, errors.position_error, 300.0)
    velocity = rng.normal(0, errors.velocity, (m, 3))
    heading = rng.normal(0, errors.heading_white, m) + markov(rng, m, 1, errors.heading_error, 60.0)[:, 0]
    epochs = tuple(record(antenna, truth, k, position[k], velocity[k], heading[k]) for k in range(m))
    times = np.arange(1, n + 1, dtype=np.int64) * STEP_NS
    return Drive(times, samples, epochs, truth, position, heading)


def markov(rng: np.random.Generator, count: int, axes: int, sigma: float, time: float) -> Array:
    """(count, axes) first-order Gauss-Markov at 1 Hz, stationary from the start."""
    keep = math.exp(-1.0 / time)
    drive = rng.normal(0, sigma * math.sqrt(1 - keep * keep), (count, axes))
    drive[0] = rng.normal(0, sigma, axes)
    for k in range(1, count):
        drive[k] += keep * drive[k - 1]
    return drive


def record(
    antenna: TruthBatch, truth: TruthBatch, k: int, position: Array, velocity: Array, heading: float
) -> NDArray[np.int64]:
    """The epoch of second number `k`: truth plus errors, in the record's integers."""
    e = gnss.new_epoch()
    w2 = 1.0 - E2 * math.sin(antenna.latitude[k]) ** 2
    lat = antenna.latitude[k] + position[0] / (A * (1 - E2) / w2**1.5 + antenna.height[k])
    lon = antenna.longitude[k] + position[1] / ((A / math.sqrt(w2) + antenna.height[k]) * math.cos(lat))
    e[gnss.FLAGS] = (
        gnss.HAS_TIME
        | gnss.HAS_POSITION
        | gnss.HAS_HEIGHT
        | gnss.HAS_VELOCITY
        | gnss.HAS_HEADING
        | gnss.HAS_BASELINE
    )
    e[gnss.TIME_OF_DAY_MS] = int(truth.times_ns[k]) // 1_000_000
    e[gnss.LAT_NANODEG] = round(math.degrees(lat) * 1e9)
    e[gnss.LON_NANODEG] = round(math.degrees(lon) * 1e9)
    e[gnss.HEIGHT_MM] = round((antenna.height[k] - position[2]) * 1e3)
    told = np.round((antenna.v_ned[k] + velocity) * 1e3)
    e[gnss.VEL_N_MMPS : gnss.VEL_D_MMPS + 1] = told.astype(np.int64)
    e[gnss.HEADING_E5DEG] = round(math.degrees(truth.yaw[k] + heading) % 360.0 * 1e5)
    e[gnss.BASELINE_MM] = round(math.hypot(*BASELINE) * 1e3)
    e[gnss.FIX_TYPE] = 3
    e[gnss.HDOP_CENTI] = 100
    e[gnss.VALID_NS] = truth.times_ns[k]
    return e


def changed(drive: Drive, first_s: float, last_s: float, change: object) -> Drive:
    """The drive with `change(record)` done to copies of the epochs valid from `first_s` to `last_s`."""
    epochs = []
    for e in drive.epochs:
        one = e.copy()
        if first_s * NS <= one[gnss.VALID_NS] <= last_s * NS:
            change(one)  # type: ignore[operator]
        epochs.append(one)
    return replace(drive, epochs=tuple(epochs))
