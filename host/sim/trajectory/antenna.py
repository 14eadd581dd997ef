"""Position and velocity of another point of the body, such as an antenna (source 002, eqs. 3-45 and 3-46).

    r_P = r + diag(1/(M+h), 1/((N+h) cos φ), −1) C_n_b l,   v_P = v + C_n_b ((ω_ib − C_b_n ω_ie) × l)

The turn of the north-east-down axes over the lever arm is left out: 2e-7 rad for each metre, so that a metre
of lever arm gives the position to a micrometre and the velocity to 1e-5 m/s at 30 m/s.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from host.sim.compiled import entry
from host.sim.earth import EARTH_RATE, radii
from host.sim.sine import sincos
from host.sim.trajectory.kinematics import C_NB, HEIGHT, LATITUDE, LONGITUDE, OMEGA_IB, VELOCITY
from host.sim.trajectory.motion import Motion


def antenna_states(
    motion: Motion, times_ns: NDArray[np.int64], lever_arm: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Rows of truth (n, 24) whose position and velocity are those of the point at `lever_arm` (body, m)."""
    rows = motion.rows(times_ns)
    move_rows(rows, lever_arm)
    return rows


@entry
def move_rows(rows: NDArray[np.float64], lever: NDArray[np.float64]) -> None:
    """Move position and velocity in rows of truth by the lever arm."""
    for k in range(rows.shape[0]):
        row = rows[k]
        sl, cl = sincos(row[LATITUDE])
        m, n = radii(sl)
        ie_n, ie_d = EARTH_RATE * cl, -EARTH_RATE * sl
        x = row[OMEGA_IB] - row[C_NB] * ie_n - row[C_NB + 6] * ie_d
        y = row[OMEGA_IB + 1] - row[C_NB + 1] * ie_n - row[C_NB + 7] * ie_d
        z = row[OMEGA_IB + 2] - row[C_NB + 2] * ie_n - row[C_NB + 8] * ie_d
        vx, vy, vz = y * lever[2] - z * lever[1], z * lever[0] - x * lever[2], x * lever[1] - y * lever[0]
        north = row[C_NB] * lever[0] + row[C_NB + 1] * lever[1] + row[C_NB + 2] * lever[2]
        east = row[C_NB + 3] * lever[0] + row[C_NB + 4] * lever[1] + row[C_NB + 5] * lever[2]
        down = row[C_NB + 6] * lever[0] + row[C_NB + 7] * lever[1] + row[C_NB + 8] * lever[2]
        for i in range(3):
            c = C_NB + 3 * i
            row[VELOCITY + i] += row[c] * vx + row[c + 1] * vy + row[c + 2] * vz
        row[LATITUDE] += north / (m + row[HEIGHT])
        row[LONGITUDE] += east / ((n + row[HEIGHT]) * cl)
        row[HEIGHT] -= down
