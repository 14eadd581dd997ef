"""Inputs of the navigation kernels for the gate: states met on a short drive, every phase of it.

A minute in closed form: rest, a straight start, turns at 10 m/s, ten seconds without GNSS, bad samples at
times. The compiled kernels themselves make the states; the gate then takes single steps from them both ways.
"""

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware.apps.car_mems.sample_clock import CLOCK_SIZE, reset_clock
from firmware.apps.car_mems.steps import APP_SIZE, CLOCK_AT
from firmware.drivers import gnss_epoch as gnss
from firmware.nav import layout
from firmware.nav.attitude_reference import attitude_step
from firmware.nav.config import NavConfig, configure, new_state
from firmware.nav.full_combination import full_combination
from firmware.nav.gnss import gnss_step
from firmware.nav.imu import imu_step

STEP_NS = 10_000_000
STEPS = 6_000
GRAVITY = 9.80665
EARTH_RADIUS = 6_371_000.0
LATITUDE, LONGITUDE = math.radians(50.0), math.radians(8.0)
REST_S, START_S, OUTAGE_S = 20.0, 30.0, (45.0, 55.0)
TURN_RATE, SPEED = 0.1, 10.0
COUNT_PER_RADIAN_S = 16.4 * 180.0 / math.pi
COUNT_PER_G = 16_384.0


@dataclass(frozen=True)
class Moment:
    """A state, and what comes next: a sample (rate 3, force 3) and at full seconds an epoch."""

    f: NDArray[np.float32]
    i: NDArray[np.int64]
    t_ns: int
    sample: tuple[float, ...]
    epoch: NDArray[np.int64] | None


@functools.cache
def moments() -> tuple[Moment, ...]:
    f = np.zeros(layout.F_SIZE + APP_SIZE, np.float32)
    i = np.zeros(layout.I_SIZE + CLOCK_SIZE, np.int64)
    configure(f[: layout.F_SIZE], i[: layout.I_SIZE], NavConfig())
    reset_clock(i, int(CLOCK_AT))
    return _drive(f, i, layout.F_SIZE, layout.I_SIZE)


@functools.cache
def referenced_moments() -> tuple[Moment, ...]:
    """The same with two antennas."""
    config = full_combination((2.0, 0.3, 0.1), sample_period=0.01, gyro_bias_sigma=0.005)
    f, i = new_state(config)
    return _drive(f, i, len(f), len(i))


def _drive(f: NDArray[np.float32], i: NDArray[np.int64], floats: int, integers: int) -> tuple[Moment, ...]:
    """`floats`, `integers`: how much of both is navigation's."""
    rng = np.random.Generator(np.random.PCG64(3))
    chosen = set(rng.integers(0, STEPS, 150).tolist()) | set(range(99, STEPS, 100))
    north = east = 0.0
    found = []
    for k in range(STEPS):
        t_ns, t = (k + 1) * STEP_NS, (k + 1) * 0.01
        speed = min(max(t - REST_S, 0.0), SPEED)
        turn = TURN_RATE if t > START_S else 0.0
        heading = TURN_RATE * max(t - START_S, 0.0)
        north += speed * math.cos(heading) * 0.01
        east += speed * math.sin(heading) * 0.01
        ahead = 1.0 if REST_S < t < START_S else 0.0
        rate = rng.normal([0.002, -0.003, turn + 0.001], 0.002)
        force = rng.normal([ahead + 0.05, speed * turn - 0.02, -GRAVITY], 0.02)
        sample = tuple(float(x) for x in np.concatenate([rate, force]))
        if k % 997 == 500:
            sample = (math.nan, *sample[1:])
        receives = t_ns % 1_000_000_000 == 0 and not OUTAGE_S[0] < t < OUTAGE_S[1]
        epoch = _epoch(t_ns, north, east, speed, heading) if receives else None
        if k in chosen:
            found.append(Moment(f.copy(), i.copy(), t_ns, sample, epoch))
        imu_step(f[:floats], i[:integers], t_ns, 0.01, *sample)
        if epoch is not None:
            gnss_step(f[:floats], i[:integers], epoch)
            attitude_step(f[:floats], i[:integers], epoch)
    return tuple(found)


def _epoch(t_ns: int, north: float, east: float, speed: float, heading: float) -> NDArray[np.int64]:
    epoch = gnss.new_epoch()
    epoch[gnss.FLAGS] = 0xFF | gnss.HAS_HEADING | gnss.HAS_PITCH | gnss.HAS_ROLL | gnss.HAS_BASELINE
    epoch[gnss.HEADING_E5DEG] = round(math.degrees(heading % (2 * math.pi)) * 1e5)
    epoch[gnss.BASELINE_MM] = 2025
    epoch[gnss.TIME_OF_DAY_MS] = t_ns // 1_000_000
    epoch[gnss.DATE_DAYS] = 15_000
    epoch[gnss.LAT_NANODEG] = round(math.degrees(LATITUDE + north / EARTH_RADIUS) * 1e9)
    epoch[gnss.LON_NANODEG] = round(math.degrees(LONGITUDE + east / EARTH_RADIUS / math.cos(LATITUDE)) * 1e9)
    epoch[gnss.HEIGHT_MM] = 120_000
    epoch[gnss.SPEED_MMPS] = round(speed * 1e3)
    epoch[gnss.COURSE_E5DEG] = round(math.degrees(heading % (2 * math.pi)) * 1e5)
    epoch[gnss.VEL_N_MMPS] = round(speed * math.cos(heading) * 1e3)
    epoch[gnss.VEL_E_MMPS] = round(speed * math.sin(heading) * 1e3)
    epoch[[gnss.H_ACC_MM, gnss.V_ACC_MM, gnss.S_ACC_MMPS]] = 1500, 2500, 50
    epoch[[gnss.FIX_QUALITY, gnss.SATELLITES, gnss.FIX_TYPE]] = 1, 12, 3
    epoch[[gnss.BURST_START_NS, gnss.BURST_END_NS]] = t_ns - 200_000_000, t_ns
    epoch[gnss.VALID_NS] = t_ns - 280_000_000
    return epoch


def _any_moment(rng: np.random.Generator) -> Moment:
    return moments()[rng.integers(0, len(moments()))]


def for_imu_step(rng: np.random.Generator) -> tuple[Any, ...]:
    now = _any_moment(rng)
    return now.f, now.i, now.t_ns, 0.01, *now.sample


def for_gnss_step(rng: np.random.Generator) -> tuple[Any, ...]:
    received = [moment for moment in moments() if moment.epoch is not None]
    now = received[rng.integers(0, len(received))]
    return now.f, now.i, now.epoch


def for_attitude_step(rng: np.random.Generator) -> tuple[Any, ...]:
    """Records as they should be, flipped, off, of another length, old, without one angle or another."""
    received = [moment for moment in referenced_moments() if moment.epoch is not None]
    now = received[rng.integers(0, len(received))]
    assert now.epoch is not None
    e = now.epoch.copy()
    off = rng.choice([0, 0, 300_000, 18_000_000])
    e[gnss.HEADING_E5DEG] = (e[gnss.HEADING_E5DEG] + off) % 36_000_000
    e[[gnss.PITCH_E5DEG, gnss.ROLL_E5DEG]] = rng.integers(-300_000, 300_000, 2)
    e[gnss.BASELINE_MM] += rng.choice([0, 0, 0, 200])
    e[gnss.FLAGS] &= ~(rng.integers(0, 8) << 9)
    e[gnss.VALID_NS] -= rng.choice([0, 0, 0, 5_000_000_000])
    return now.f, now.i, e


def for_attitude_report(rng: np.random.Generator) -> tuple[Any, ...]:
    now = referenced_moments()[rng.integers(0, len(referenced_moments()))]
    return now.f, now.i, np.zeros(64, np.float32), np.zeros(64, np.int64)


def for_solution(rng: np.random.Generator) -> tuple[Any, ...]:
    now = _any_moment(rng)
    return now.f, now.i, np.zeros(64, np.float32), np.zeros(64, np.int64)


def for_series(rng: np.random.Generator) -> tuple[Any, ...]:
    return _any_moment(rng).f, np.zeros(64, np.float32)


def for_raw_sample(rng: np.random.Generator) -> tuple[Any, ...]:
    """A burst of the sensor: status, rate and force in counts, 24 bits of sensor time."""
    now = _any_moment(rng)
    si = np.nan_to_num(np.array(now.sample))
    counts = np.concatenate([si[:3] * COUNT_PER_RADIAN_S, si[3:] / GRAVITY * COUNT_PER_G])
    clipped = np.clip(np.round(counts), -32768, 32767).astype("<i2")
    ticks = (now.t_ns // 39_062) & 0xFFFFFF
    raw = bytes([0]) + clipped.tobytes() + ticks.to_bytes(3, "little")
    f = now.f.copy()
    f[layout.F_SIZE + 6] = rng.integers(0, 10)
    return f, now.i, np.frombuffer(bytearray(raw), np.uint8), now.t_ns


def for_increments(rng: np.random.Generator) -> tuple[Any, ...]:
    """A sample of the serial unit: increments over 5 ms in its units, status, time."""
    now = _any_moment(rng)
    si = np.nan_to_num(np.array(now.sample))
    units = np.concatenate([si[:3] / 2.0e-7, si[3:] / 2.0e-6])
    limit = 2**31 - 1
    counts = np.clip(np.round(units), -limit, limit).astype(np.int64)
    status = int(rng.choice([0, 0, 0, 0, 1, 2, 3, 4, 8]))
    missed = int(rng.integers(0, 4))
    return now.f, now.i, np.array([7, *counts, status, now.t_ns, missed], np.int64)


def for_sample_time(rng: np.random.Generator) -> tuple[Any, ...]:
    """A clock in lock, new, or off, and the next sample, the same one, or one after a gap."""
    i = np.zeros(CLOCK_SIZE, np.int64)
    reset_clock(i, 0)
    ticks, time_ns = int(rng.integers(0, 2**24)), int(rng.integers(0, 2**40))
    if rng.integers(0, 4) > 0:
        i[0], i[1] = ticks & 0xFFFF00, time_ns
        i[2] += rng.integers(-(2**20), 2**20)
    step = int(rng.choice([0, 256, 256, 512, 100 * 256, 101 * 256, 2**23]))
    late_ns = int(rng.choice([0, 50_000, -50_000, 3_000_001, -(10**9)]))
    return i, 0, (ticks + step) % 2**24, time_ns + step * 39_062 + late_ns


INPUTS = {
    "firmware.nav.imu.imu_step": for_imu_step,
    "firmware.nav.gnss.gnss_step": for_gnss_step,
    "firmware.nav.attitude_reference.attitude_step": for_attitude_step,
    "firmware.nav.reference_report.attitude_report": for_attitude_report,
    "firmware.nav.solution.solution": for_solution,
    "firmware.nav.solution.covariance": for_series,
    "firmware.nav.solution.innovation": for_series,
    "firmware.nav.solution.biases": for_series,
    "firmware.apps.car_mems.sample_clock.sample_time": for_sample_time,
    "firmware.apps.car_mems.steps.data_ready_step": for_raw_sample,
    "firmware.apps.car_mems.steps.timer_sample": for_raw_sample,
    "firmware.apps.dual_antenna.steps.sample_step": for_increments,
}
