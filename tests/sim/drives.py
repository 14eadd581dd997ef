"""Scenarios of the board and what tests do with their truth."""

from pathlib import Path

import ecef_mechanization as oracle
import numpy as np
from scipy.spatial.transform import Rotation

SCENARIOS = Path(__file__).parents[2] / "boards" / "car_mems" / "scenarios"
PERFECT = ["imu.preset=perfect"]
SMOOTH = [f"vibration.{axis}_mps2=0.0" for axis in "xyz"] + ["sway.roll_deg=0.0", "sway.pitch_deg=0.0"]


def earth_state(row, lever):
    """State (10,) of the oracle at a point of the body, from a row of truth; and C_e_n."""
    c_en = oracle.rotation_ned_to_ecef(row[0], row[1])
    c_eb = c_en @ row[6:15].reshape(3, 3)
    w_eb = row[15:18] - c_eb.T @ [0.0, 0.0, oracle.W]
    position = oracle.ecef(*row[:3]) + c_eb @ lever
    velocity = c_en @ row[3:6] + c_eb @ np.cross(w_eb, lever)
    return np.concatenate((position, velocity, Rotation.from_matrix(c_eb).as_quat(scalar_first=True))), c_en


def attitude_difference(q_a, q_b):
    """Angle between two quaternions, rad."""
    a, b = (Rotation.from_quat(q, scalar_first=True) for q in (q_a, q_b))
    return (a * b.inv()).magnitude()
