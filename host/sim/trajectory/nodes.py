"""Position: the integral of the velocity over the ellipsoid, at nodes, and cubic interpolation between them.

    φ̇ = v_N / (M + h),   λ̇ = v_E / ((N + h) cos φ),   ḣ = −v_D

v_n(t) does not depend on the position, so that one step is Gauss–Legendre collocation with three stages
(order 6): the stages' displacements come from the velocities by the Butcher matrix, the radii from these.
Between nodes the Hermite cubic of positions and rates errs by less than snap · step⁴ / 384: under 1 µm at
the step chosen in `host.sim.trajectory.motion`.
"""

from __future__ import annotations

import math

import numpy as np

from host.sim.compiled import Floats, Integers, entry, inner
from host.sim.earth import radii
from host.sim.sine import sincos
from host.sim.trajectory.channels import find_pieces, path_velocity

_ROOT15 = math.sqrt(15.0)
STAGES = np.array([0.5 - _ROOT15 / 10.0, 0.5, 0.5 + _ROOT15 / 10.0])
BUTCHER = np.array(
    [
        [5.0 / 36.0, 2.0 / 9.0 - _ROOT15 / 15.0, 5.0 / 36.0 - _ROOT15 / 30.0],
        [5.0 / 36.0 + _ROOT15 / 24.0, 2.0 / 9.0, 5.0 / 36.0 - _ROOT15 / 24.0],
        [5.0 / 36.0 + _ROOT15 / 30.0, 2.0 / 9.0 + _ROOT15 / 15.0, 5.0 / 36.0],
    ]
)
WEIGHTS = np.array([5.0 / 18.0, 4.0 / 9.0, 5.0 / 18.0])


@inner
def rates_at(lat: float, h: float, vn: float, ve: float) -> tuple[float, float]:
    """Latitude and longitude rates, rad/s."""
    sl, cl = sincos(lat)
    m, n = radii(sl)
    return vn / (m + h), ve / ((n + h) * cl)


@inner
def one_step(
    layout: Integers,
    c: Floats,
    row: Integers,
    velocity: Floats,
    t_ns: int,
    step_ns: int,
    lat: float,
    lon: float,
    h: float,
) -> tuple[float, float, float]:
    """Latitude, longitude and height a step later; `row` and `velocity` (3, 3) are room to work in."""
    step = step_ns * 1e-9
    for i in range(3):
        at_ns = t_ns + int(step_ns * STAGES[i])
        find_pieces(layout, at_ns, row)
        velocity[i, 0], velocity[i, 1], velocity[i, 2] = path_velocity(layout, c, row, at_ns)
    m = radii(sincos(lat)[0])[0]
    lat_sum, lon_sum, h_sum = 0.0, 0.0, 0.0
    for i in range(3):
        north, down = 0.0, 0.0
        for j in range(3):
            north += BUTCHER[i, j] * velocity[j, 0]
            down += BUTCHER[i, j] * velocity[j, 2]
        lat_rate, lon_rate = rates_at(
            lat + step * north / (m + h), h - step * down, velocity[i, 0], velocity[i, 1]
        )
        lat_sum += WEIGHTS[i] * lat_rate
        lon_sum += WEIGHTS[i] * lon_rate
        h_sum -= WEIGHTS[i] * velocity[i, 2]
    return lat + step * lat_sum, lon + step * lon_sum, h + step * h_sum


@entry
def integrate_nodes(
    layout: Integers, c: Floats, start_ns: int, shift: int, position: Floats, out: Floats
) -> None:
    """Fill `out` (n + 1, 6) = lat, lon, h and their rates at start_ns + k · 2^shift, from `position` on."""
    row = layout[:4].copy()
    velocity = np.empty((3, 3))
    step_ns = 1 << shift
    lat, lon, h = position[0], position[1], position[2]
    for k in range(out.shape[0]):
        t_ns = start_ns + k * step_ns
        find_pieces(layout, t_ns, row)
        vn, ve, vd = path_velocity(layout, c, row, t_ns)
        lat_rate, lon_rate = rates_at(lat, h, vn, ve)
        out[k, 0], out[k, 1], out[k, 2] = lat, lon, h
        out[k, 3], out[k, 4], out[k, 5] = lat_rate, lon_rate, -vd
        if k + 1 < out.shape[0]:
            lat, lon, h = one_step(layout, c, row, velocity, t_ns, step_ns, lat, lon, h)


@entry
def advance(layout: Integers, c: Floats, from_ns: int, to_ns: int, position: Floats, out: Floats) -> None:
    """Latitude, longitude, height at `to_ns` into `out` (3), from those at `from_ns`, in one step."""
    row = layout[:4].copy()
    velocity = np.empty((3, 3))
    out[0], out[1], out[2] = one_step(
        layout, c, row, velocity, from_ns, to_ns - from_ns, position[0], position[1], position[2]
    )


@entry
def position_at_times(nodes: Floats, start_ns: int, shift: int, times_ns: Integers, out: Floats) -> None:
    """Latitude, longitude and height (n, 3) by the cubics."""
    lane = np.empty((3, 1))
    for k in range(times_ns.shape[0]):
        position_at(nodes, start_ns, shift, times_ns[k], 0, lane)
        for i in range(3):
            out[k, i] = lane[i, 0]


@inner
def position_at(nodes: Floats, start_ns: int, shift: int, t_ns: int, j: int, out: Floats) -> None:
    """Latitude, longitude and height at an instant that lies between the nodes, into lane `j` of `out`."""
    k = (t_ns - start_ns) >> shift
    step_ns = 1 << shift
    step = step_ns * 1e-9
    x = (t_ns - start_ns - k * step_ns) / step_ns
    y = 1.0 - x
    a, b = x * x * (3.0 - 2.0 * x), step * x * y
    for i in range(3):
        p = nodes[k, i]
        out[i, j] = p + a * (nodes[k + 1, i] - p) + b * (y * nodes[k, 3 + i] - x * nodes[k + 1, 3 + i])
