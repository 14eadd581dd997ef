"""From exact motion to what one inertial sensor feels, sample by sample.

Away from the vehicle's origin by the lever arm l (body axes), a rigid body feels

    f = f₀ + ω̇ × l + ω × (ω × l) − C_b_n (G(l) − G(0)),   ω = ω_ib,

where the change of gravitation G over l is the tilt of the plumb line, the free-air gradient and the
centrifugal part of gravity. The white noise keeps its density n at low frequency whatever the filter's noise
bandwidth B: with r = 2 B Δt < 1 it is a first-order filtered sequence of σ² = n² B, from r = 1 on (aliased) a
white one of the same σ².
"""

from __future__ import annotations

import math

import numpy as np

from host.sim.compiled import Floats, Integers, entry, inner
from host.sim.earth import EARTH_RATE, gravity, radii
from host.sim.sine import sincos
from host.sim.trajectory.kinematics import C_NB, FORCE, HEIGHT, LATITUDE, OMEGA_DOT, OMEGA_IB, ROW

LEVER, MOUNTING, CROSS_G, CROSS_A, G_SENSITIVITY, DENSITY, SQUARE_G, SQUARE_A = 0, 3, 12, 21, 30, 39, 45, 48
CONSTANTS = 51
"""Where the sensor's constants stand: l(3), C_b_s(9), couplings(9, 9), G(9), noise densities (3, 3), factors
of the squares (3, 3)."""

BIAS_G, BIAS_A, SCALE_G, SCALE_A, TEMPERATURE, SLOW = 0, 3, 6, 9, 12, 13
"""Columns of the slowly changing errors."""

NOISE_MEMORY = 7
"""Filtered noise gyro(3), accel(3), and the time of the last sample in s (negative: none)."""


@inner
def lever_effect(lever: Floats, row: Floats) -> None:
    """Move the specific force in a row of truth from the origin to the lever arm l[0 … 2]."""
    x, y, z = lever[0], lever[1], lever[2]
    wx, wy, wz = row[OMEGA_IB], row[OMEGA_IB + 1], row[OMEGA_IB + 2]
    ax, ay, az = row[OMEGA_DOT], row[OMEGA_DOT + 1], row[OMEGA_DOT + 2]
    cx, cy, cz = wy * z - wz * y, wz * x - wx * z, wx * y - wy * x
    north = row[C_NB] * x + row[C_NB + 1] * y + row[C_NB + 2] * z
    east = row[C_NB + 3] * x + row[C_NB + 4] * y + row[C_NB + 5] * z
    down = row[C_NB + 6] * x + row[C_NB + 7] * y + row[C_NB + 8] * z
    sl, cl = sincos(row[LATITUDE])
    h = row[HEIGHT]
    m, n = radii(sl)
    there = gravity(sl + cl * north / (m + h), h - down)
    axis_n, axis_d = EARTH_RATE * cl, -EARTH_RATE * sl
    along = axis_n * north + axis_d * down
    rate2 = EARTH_RATE * EARTH_RATE
    gn = -there * north / (m + h) + along * axis_n - rate2 * north
    ge = -there * east / (n + h) - rate2 * east
    gd = there - gravity(sl, h) + along * axis_d - rate2 * down
    row[FORCE] += ay * z - az * y + wy * cz - wz * cy
    row[FORCE + 1] += az * x - ax * z + wz * cx - wx * cz
    row[FORCE + 2] += ax * y - ay * x + wx * cy - wy * cx
    for i in range(3):
        row[FORCE + i] -= row[C_NB + i] * gn + row[C_NB + 3 + i] * ge + row[C_NB + 6 + i] * gd


@entry
def move_forces(lever: Floats, rows: Floats) -> None:
    """Move the specific force in rows of truth (n, ROW) from the origin to the lever arm (3)."""
    for k in range(rows.shape[0]):
        lever_effect(lever, rows[k])


@inner
def add_noise(
    t: float, bandwidth_hz: float, sensor: Floats, normals: Floats, column: int, memory: Floats
) -> None:
    """Advance the filtered noise in `memory` to time `t` with six standard normals, a column of `normals`."""
    r = 1.0
    if memory[6] >= 0.0 and t > memory[6]:
        r = 2.0 * bandwidth_hz * (t - memory[6])
    memory[6] = t
    if r >= 1.0:
        keep, gain = 0.0, math.sqrt(bandwidth_hz)
    else:
        a = 2.0 * r / (1.0 + r)
        keep, gain = 1.0 - a, a * math.sqrt(bandwidth_hz / r)
    for i in range(6):
        memory[i] = keep * memory[i] + gain * sensor[DENSITY + i] * normals[i, column]


@entry
def sense(
    rows: Floats,
    slow: Floats,
    start_ns: int,
    slow_shift: int,
    sensor: Floats,
    bandwidth_hz: float,
    normals: Floats,
    first: int,
    memory: Floats,
    times_ns: Integers,
    out: Floats,
) -> None:
    """Fill `out` (n, 7) from rows of truth (n, ROW) at times within one chunk, which begins at `start_ns`.

    `slow` (k, 13): slowly changing errors at nodes 2^slow_shift ns apart; `normals` (6, m), used from
    column `first` on.
    """
    now = np.empty(SLOW)
    felt = np.empty(6)
    truth = np.empty(ROW)
    moved = sensor[LEVER] != 0.0 or sensor[LEVER + 1] != 0.0 or sensor[LEVER + 2] != 0.0
    slow_step_ns = 1 << slow_shift
    for i in range(times_ns.shape[0]):
        t_ns = times_ns[i]
        for j in range(ROW):
            truth[j] = rows[i, j]
        if moved:
            lever_effect(sensor, truth)
        k = (t_ns - start_ns) >> slow_shift
        x = (t_ns - start_ns - k * slow_step_ns) / slow_step_ns
        for j in range(SLOW):
            now[j] = slow[k, j] + x * (slow[k + 1, j] - slow[k, j])
        add_noise(t_ns * 1e-9, bandwidth_hz, sensor, normals, first + i, memory)
        to_sensor(truth, sensor, felt)
        apply_errors(sensor, now, felt, memory, out, i)


@inner
def to_sensor(truth: Floats, sensor: Floats, out: Floats) -> None:
    """Specific force (3) and angular rate (3) of a row of truth in the sensor's axes: C_b_sᵀ."""
    for i in range(3):
        a, b, c = sensor[MOUNTING + i], sensor[MOUNTING + 3 + i], sensor[MOUNTING + 6 + i]
        out[i] = a * truth[FORCE] + b * truth[FORCE + 1] + c * truth[FORCE + 2]
        out[3 + i] = a * truth[OMEGA_IB] + b * truth[OMEGA_IB + 1] + c * truth[OMEGA_IB + 2]


@inner
def apply_errors(sensor: Floats, slow: Floats, true: Floats, noise: Floats, out: Floats, k: int) -> None:
    """Measured force (3), rate (3) and temperature into row `k` from true force and rate."""
    for i in range(3):
        f = (1.0 + slow[SCALE_A + i]) * true[i] + slow[BIAS_A + i] + noise[3 + i]
        w = (1.0 + slow[SCALE_G + i]) * true[3 + i] + slow[BIAS_G + i] + noise[i]
        f += sensor[SQUARE_A + i] * true[i] * true[i]
        w += sensor[SQUARE_G + i] * true[3 + i] * true[3 + i]
        for j in range(3):
            f += sensor[CROSS_A + 3 * i + j] * true[j]
            w += sensor[CROSS_G + 3 * i + j] * true[3 + j] + sensor[G_SENSITIVITY + 3 * i + j] * true[j]
        out[k, i] = f
        out[k, 3 + i] = w
    out[k, 6] = slow[TEMPERATURE]
