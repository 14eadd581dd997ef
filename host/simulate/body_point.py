"""Motion of another point of the body: where a sensor or an antenna sits (source 002, eqs. 3-45 and 3-46).

    r_P = r + C_e_n C_n_b l   (Earth-fixed),   v_P = C_n'_n (v + C_n_b ((ω_nb + C_b_n ω_en) × l))

n' are north, east, down at the point: they are turned against those at the origin by 2e-7 rad for each metre,
which is left out nowhere, so that the velocity is the position's derivative to rounding.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from host.sim.earth import ecef_to_geodetic, geodetic_to_ecef
from host.simulate.attitude_forms import matrices, product
from host.simulate.flyable import Flyable, metres_per_radian

Floats = NDArray[np.float64]


def point_states(motion: Flyable, t_s: Floats, lever_m: Floats) -> Floats:
    """As `Flyable.states` (n, 10), of the point `lever_m` (3, body axes) away with the body's axes."""
    states = motion.states(t_s)
    if not lever_m.any():
        return states
    c_nb = matrices(states[:, 6:]).reshape(-1, 3, 3)
    c_en = _ned_in_earth(states[:, 0], states[:, 1])
    arm = c_nb @ lever_m
    earth = geodetic_to_ecef(*states[:, :3].T) + np.einsum("nij,nj->ni", c_en, arm)
    latitude, longitude, height = ecef_to_geodetic(earth)
    longitude += 2.0 * math.pi * np.round((states[:, 1] - longitude) / (2.0 * math.pi))
    swing = np.cross(motion.turning(t_s) + np.einsum("nji,nj->ni", c_nb, _transport(states)), lever_m)
    velocity = states[:, 3:6] + np.einsum("nij,nj->ni", c_nb, swing)
    between = np.einsum("nji,njk->nik", _ned_in_earth(latitude, longitude), c_en)
    there = np.einsum("nij,nj->ni", between, velocity)
    return np.hstack(
        (
            latitude[:, None],
            longitude[:, None],
            height[:, None],
            there,
            product(_small(between), states[:, 6:]),
        )
    )


def _transport(states: Floats) -> Floats:
    """ω_en in north-east-down (n, 3)."""
    latitude, v = states[:, 0], states[:, 3:6]
    meridian, parallel = metres_per_radian(latitude, states[:, 2])
    east = v[:, 1] / parallel
    return np.column_stack((east * np.cos(latitude), -v[:, 0] / meridian, -east * np.sin(latitude)))


def _ned_in_earth(latitude: Floats, longitude: Floats) -> Floats:
    """C_e_n (n, 3, 3)."""
    sp, cp, sl, cl = np.sin(latitude), np.cos(latitude), np.sin(longitude), np.cos(longitude)
    rows = ((-sp * cl, -sl, -cp * cl), (-sp * sl, cl, -cp * sl), (cp, np.zeros_like(sp), -sp))
    return np.moveaxis(np.array(rows), -1, 0)


def _small(turn: Floats) -> Floats:
    """Quaternions (n, 4) of matrices (n, 3, 3) of small turns."""
    vector = 0.25 * np.column_stack([turn[:, j, k] - turn[:, k, j] for j, k in ((2, 1), (0, 2), (1, 0))])
    return np.column_stack((np.sqrt(1.0 - (vector**2).sum(axis=1)), vector))
