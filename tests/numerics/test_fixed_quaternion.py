"""Quaternions and direction cosines in Q30 against the same in float64, written otherwise."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware.numerics.fixed.angles import FULL_TURN, HALF_TURN, QUARTER_TURN
from firmware.numerics.fixed.quaternion import (
    euler_of_quaternion,
    quaternion_of_euler,
    quaternion_of_matrix,
    quaternion_product,
    rotation_matrix,
    to_length_one,
)

UNIT = 2.0**-30
part = st.floats(-1.0, 1.0).filter(lambda x: abs(x) > 1e-3 or x == 0.0)
directions = st.tuples(part, part, part, part).filter(lambda q: np.linalg.norm(q) > 0.01)


def in_q30(q):
    q = np.array(q) / np.linalg.norm(q)
    return tuple(round(value * 2**30) for value in q)


def as_matrix(q):
    """The complex 2 × 2 matrix of a quaternion: products of quaternions are products of these."""
    w, x, y, z = np.array(q, np.float64)
    return np.array([[w + 1j * x, y + 1j * z], [-y + 1j * z, w - 1j * x]])


@given(directions, directions)
def test_product_is_that_of_the_complex_matrices(a, b):
    a, b = in_q30(a), in_q30(b)
    found = as_matrix(quaternion_product(*a, *b, 30)) * UNIT
    assert found == pytest.approx(as_matrix(a) @ as_matrix(b) * UNIT * UNIT, abs=0.75 * UNIT)


@given(directions)
def test_matrix_turns_as_the_quaternion_does(q):
    q = in_q30(q)
    w, v = q[0] * UNIT, np.array(q[1:]) * UNIT
    skew = np.cross(v, np.eye(3)).T
    expected = (w * w - v @ v) * np.eye(3) + 2.0 * np.outer(v, v) + 2.0 * w * skew
    found = np.array(rotation_matrix(*q)).reshape(3, 3) * UNIT
    assert found == pytest.approx(expected, abs=4.0 * UNIT)


@given(directions)
def test_quaternion_of_its_matrix_is_the_same_rotation(q):
    q = np.array(in_q30(q))
    found = np.array(quaternion_of_matrix(*rotation_matrix(*(int(value) for value in q))))
    sign = 1 if found @ q.astype(float) > 0 else -1
    assert np.abs(sign * found - q).max() <= 6


@given(directions, st.floats(-1e-4, 1e-4))
def test_one_step_mends_the_length(q, wrong):
    q = tuple(round(value * (1.0 + wrong)) for value in in_q30(q))
    found = np.array(to_length_one(*q)) * UNIT
    assert np.linalg.norm(found) == pytest.approx(1.0, abs=1.5 * wrong**2 + 3.0 * UNIT)


yaws = st.integers(-HALF_TURN, HALF_TURN - 1)
pitches = st.integers(-QUARTER_TURN + 2**23, QUARTER_TURN - 2**23)


@given(yaws, pitches, yaws)
def test_angles_of_their_quaternion_come_back(yaw, pitch, roll):
    """Near ±90° of pitch yaw and roll lose as the cosine of pitch does; here it is 0.012 and more."""
    found = euler_of_quaternion(*quaternion_of_euler(yaw, pitch, roll))
    wider = 1.0 / math.cos(pitch * math.pi / 2**31)
    for angle, expected, bound in zip(found, (yaw, pitch, roll), (wider, 1.0, wider), strict=True):
        assert abs((angle - expected + HALF_TURN) % FULL_TURN - HALF_TURN) <= 6.0 * bound


@pytest.mark.parametrize("pitch", [QUARTER_TURN, -QUARTER_TURN])
@pytest.mark.parametrize("yaw", [0, 12345678, -HALF_TURN, 2**30])
def test_gimbal_lock_leaves_the_rest_to_yaw(pitch, yaw):
    found_yaw, found_pitch, roll = euler_of_quaternion(*quaternion_of_euler(yaw, pitch, 0))
    assert roll == 0
    assert abs(found_pitch - pitch) < 2**16
    assert abs((found_yaw - yaw + HALF_TURN) % FULL_TURN - HALF_TURN) <= 6
