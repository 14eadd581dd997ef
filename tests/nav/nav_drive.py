"""Offline harness: World → samples and epochs, as navigation would get them from a board.

The chips are replaced by rounding to their steps; a GNSS epoch arrives `burst_s` after its first byte.
"""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware.drivers import gnss_epoch as gnss
from host.sim.scenario.load import load_scenario
from host.sim.truth import TruthBatch
from host.sim.world import World

Array = NDArray[np.float64]
NS = 1_000_000_000
SCENARIOS = Path(__file__).parents[2] / "boards" / "car_mems" / "scenarios"
GYRO_STEP = math.radians(1.0 / 131.2)
ACCEL_STEP = 9.80665 / 8192.0
BANDWIDTH_HZ = 40.0


@dataclass
class Drive:
    """What the sensors told in one run, and the truth at every tenth of a second."""

    times_ns: NDArray[np.int64]
    samples: Array
    """(n, 6) rate, specific force."""
    temperature: Array
    """(n,) of the chip, °C, in its steps."""
    epochs: list[tuple[int, NDArray[np.int64]]]
    """(arrival in ns, record) in rising order."""
    truth: TruthBatch
    outages: list[tuple[float, float]]
    fixes: Array
    """(m, 4) time, error of the receiver north, east, down."""


def make_drive(
    scenario: str | Path,
    seed: int = 1,
    *,
    thesis: bool = False,
    overrides: tuple[str, ...] = (),
    time_pulse: bool = True,
    velocity: str = "3d",
    burst_s: float = 0.35,
    gnss_rate: float = 1.0,
    duration_s: float | None = None,
    data_dir: Path | None = None,
) -> Drive:
    """Run the world of a scenario. `velocity`: "3d" or "2d" (speed and course)."""
    path = scenario if isinstance(scenario, Path) else SCENARIOS / f"{scenario}.toml"
    world = World(load_scenario(path, overrides), seed, data_dir)
    end = world.duration_ns if duration_s is None else min(world.duration_ns, round(duration_s * NS))
    times = np.arange(1, end // 10_000_000 - 1, dtype=np.int64) * 10_000_000
    sensor = world.imu("imu")
    blocks = [sensor.sample(times[k : k + 1000], BANDWIDTH_HZ) for k in range(0, len(times), 1000)]
    raw = np.concatenate(blocks)
    rate = np.round(raw[:, 3:6] / GYRO_STEP) * GYRO_STEP
    force = np.round(raw[:, :3] / ACCEL_STEP) * ACCEL_STEP
    samples = np.hstack((rate, force))
    temperature = np.round(raw[:, 6] * 512.0) / 512.0
    if thesis:
        whole = len(times) // 10 * 10
        samples = samples[:whole].reshape(-1, 10, 6).mean(axis=1)
        times = times[:whole].reshape(-1, 10)[:, -1] + 5_000_000
        temperature = temperature[9:whole:10]
    epochs, fixes = _epochs(world, end, gnss_rate, time_pulse, velocity, burst_s)
    truth_ns = np.arange(1, end // 100_000_000 - 1, dtype=np.int64) * 100_000_000
    outages = [(o.start_ns / NS, o.end_ns / NS) for o in world.outages]
    return Drive(times, samples, temperature, epochs, world.truth(truth_ns), outages, fixes)


def _epochs(
    world: World, end: int, rate: float, time_pulse: bool, velocity: str, burst_s: float
) -> tuple[list[tuple[int, NDArray[np.int64]]], Array]:
    receiver = world.gnss("gnss")
    valid = (np.arange(1, int(end / NS * rate)) * (NS / rate)).astype(np.int64)
    truth = world.antenna_truth(valid, np.zeros(3))
    epochs, fixes = [], []
    for n, t in enumerate(valid.tolist()):
        told = receiver.epoch(t)
        if not told.fix:
            continue
        record = epoch_record(told, velocity)
        record[gnss.VALID_NS] = t if time_pulse else t + told.latency_ns - 80_000_000
        epochs.append((t + told.latency_ns + round(burst_s * NS), record))
        r = 6378137.0
        fixes.append(
            (
                t / NS,
                (told.latitude - truth.latitude[n]) * r * 0.995,
                within_pi(told.longitude - truth.longitude[n]) * r * math.cos(told.latitude),
                truth.height[n] - told.height,
            )
        )
    return epochs, np.array(fixes)


def epoch_record(told: Any, velocity: str) -> NDArray[np.int64]:
    """A GnssEpoch as the parser would write it; validity is left open."""
    record = gnss.new_epoch()
    flags = gnss.HAS_TIME | gnss.HAS_DATE | gnss.HAS_POSITION | gnss.HAS_HEIGHT | gnss.HAS_ACCURACY
    record[gnss.TIME_OF_DAY_MS] = (told.gps_time_ns // 1_000_000 - 18_000) % 86_400_000
    record[gnss.LAT_NANODEG] = round(math.degrees(told.latitude) * 1e9)
    record[gnss.LON_NANODEG] = round(math.degrees(told.longitude) * 1e9)
    record[gnss.HEIGHT_MM] = round(told.height * 1e3)
    vn, ve, vd = told.velocity_ned
    speed = math.hypot(vn, ve)
    if velocity == "3d":
        flags |= gnss.HAS_VELOCITY
        record[gnss.VEL_N_MMPS : gnss.VEL_D_MMPS + 1] = [round(v * 1e3) for v in (vn, ve, vd)]
        record[gnss.S_ACC_MMPS] = round(told.s_acc * 1e3)
    flags |= gnss.HAS_SPEED
    record[gnss.SPEED_MMPS] = round(speed * 1e3)
    if speed > 0.5:
        flags |= gnss.HAS_COURSE
        record[gnss.COURSE_E5DEG] = round(math.degrees(math.atan2(ve, vn)) % 360.0 * 100.0) % 36000 * 1000
    record[gnss.H_ACC_MM] = round(told.h_acc * 1e3)
    record[gnss.V_ACC_MM] = round(told.v_acc * 1e3)
    record[gnss.HDOP_CENTI] = round(told.hdop * 100)
    record[gnss.VDOP_CENTI] = round(told.vdop * 100)
    record[gnss.FIX_TYPE] = 3
    record[gnss.FLAGS] = flags
    return record


def part(drive: Drive, start_s: float, end_s: float) -> Drive:
    """A stretch of a drive, times kept; the copy may be spoilt."""
    start, end = round(start_s * NS), round(end_s * NS)
    t = drive.times_ns
    chosen = (t >= start) & (t < end)
    truth = drive.truth
    k = (truth.times_ns >= start) & (truth.times_ns < end)
    columns = {name: getattr(truth, name)[k] for name in truth.__dataclass_fields__}
    return Drive(
        t[chosen].copy(),
        drive.samples[chosen].copy(),
        drive.temperature[chosen].copy(),
        [(arrival, record.copy()) for arrival, record in drive.epochs if start <= arrival < end],
        replace(truth, **columns),
        [],
        drive.fixes[(drive.fixes[:, 0] >= start_s) & (drive.fixes[:, 0] < end_s)].copy(),
    )


def without_samples(drive: Drive, start_s: float, end_s: float) -> Drive:
    """The drive with a gap in its samples."""
    changed = copy.copy(drive)
    keep = (drive.times_ns <= start_s * NS) | (drive.times_ns > end_s * NS)
    changed.times_ns, changed.samples = drive.times_ns[keep], drive.samples[keep]
    changed.temperature = drive.temperature[keep]
    return changed


def rows(drive: Drive, start_s: float, end_s: float) -> slice:
    """Which samples lie between two times."""
    first, last = np.searchsorted(drive.times_ns, [round(start_s * NS), round(end_s * NS)])
    return slice(int(first), int(last))


def within_pi(angle: Any) -> Any:
    """Angles in [−π, π)."""
    return (angle + math.pi) % (2 * math.pi) - math.pi
