"""Inputs of the fixed-point quaternions for the gate: those of length 1, in Q30, and all axes."""

import numpy as np

AXES = [(1, 0, 0, 0), (0, 1, 0, 0), (0, 0, -1, 0), (0.5, -0.5, 0.5, 0.5), (2**-0.5, 0, 2**-0.5, 0)]


def unit_quaternion(rng: np.random.Generator) -> tuple[int, ...]:
    """One of the axes or any other direction."""
    q = np.array(AXES[rng.integers(0, len(AXES))]) if rng.integers(0, 3) == 0 else rng.normal(0.0, 1.0, 4)
    return tuple(round(part * 2**30) for part in q / np.linalg.norm(q))


INPUTS = {
    "firmware.numerics.fixed.quaternion.rotation_matrix": unit_quaternion,
    "firmware.numerics.fixed.quaternion.euler_of_quaternion": unit_quaternion,
}
