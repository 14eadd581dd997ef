import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from firmware.numerics.quaternion import (
    euler_of_quaternion,
    normalise_quaternion,
    quaternion_of_euler,
    quaternion_of_rotation,
    quaternion_product,
    rotate_vector,
    rotate_vector_back,
    rotation_matrix,
    wrap_heading,
)

FEW_ULP = 5e-7
TWO_PI_32 = np.float32(2.0 * math.pi)

angles = st.floats(-7.0, 7.0, width=32)
components = st.floats(-1.0, 1.0, width=32)
vectors = st.tuples(*[st.floats(-100.0, 100.0, width=32)] * 3)


@st.composite
def unit_quaternions(draw):
    q = np.array(draw(st.tuples(*[components] * 4)), np.float64)
    length = np.linalg.norm(q)
    q = q / length if length > 0.1 else np.array([1.0, 0.0, 0.0, 0.0])
    return tuple(q.astype(np.float32))


def rotation_of(q):
    return Rotation.from_quat(np.asarray(q, np.float64), scalar_first=True)


def same_rotation(q, reference, tolerance=FEW_ULP):
    """The angle between two rotations; q and −q are one."""
    return (rotation_of(q) * reference.inv()).magnitude() < tolerance


def tait_bryan(yaw, pitch, roll):
    return Rotation.from_euler("ZYX", [float(yaw), float(pitch), float(roll)])


@given(unit_quaternions(), unit_quaternions())
def test_product_is_the_product_of_the_rotations(a, b):
    assert same_rotation(quaternion_product(*a, *b), rotation_of(a) * rotation_of(b))


def test_product_is_hamiltons():
    i, j, k = (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)
    assert quaternion_product(*i, *j) == k
    assert quaternion_product(*j, *k) == i
    assert quaternion_product(*k, *i) == j
    assert quaternion_product(*i, *i) == (-1, 0, 0, 0)


@given(st.tuples(*[st.floats(-1000.0, 1000.0, width=32)] * 4))
def test_normalised_has_length_one_and_the_same_direction(q):
    length = math.sqrt(sum(float(x) ** 2 for x in q))
    if length < 1e-15:
        return
    got = normalise_quaternion(*q)
    assert got == pytest.approx([x / length for x in q], abs=2e-7)


def test_zero_quaternion_becomes_no_rotation():
    assert normalise_quaternion(0.0, 0.0, 0.0, 0.0) == (1.0, 0.0, 0.0, 0.0)


def test_nan_is_not_hidden_by_normalising():
    assert all(math.isnan(x) for x in normalise_quaternion(1.0, math.nan, 0.0, 0.0))


@given(st.tuples(*[st.floats(-4.0, 4.0, width=32)] * 3))
def test_rotation_vector_of_any_length(vector):
    q = quaternion_of_rotation(*vector)
    assert same_rotation(q, Rotation.from_rotvec(np.asarray(vector, np.float64)), 1e-6)
    assert sum(x * x for x in q) == pytest.approx(1.0, abs=FEW_ULP)


@pytest.mark.parametrize("angle", [0.0, 1e-45, 1e-20, 1e-4, 0.4999999, 0.5, 0.5000001, 3.1, 6.2])
def test_rotation_vector_about_one_axis(angle):
    """On both sides of the change from series to sine, and where squares vanish."""
    angle = float(np.float32(angle))
    w, x, y, z = quaternion_of_rotation(0.0, angle, 0.0)
    assert (x, z) == (0.0, 0.0)
    assert w == pytest.approx(math.cos(angle / 2), abs=1e-7)
    assert y == pytest.approx(math.sin(angle / 2), rel=3e-7, abs=1e-45)


@given(unit_quaternions())
def test_rotation_matrix(q):
    want = rotation_of(q).as_matrix().ravel()
    assert rotation_matrix(*q) == pytest.approx(want, abs=FEW_ULP)


@given(unit_quaternions(), vectors)
def test_rotated_vector(q, v):
    want = rotation_of(q).apply(np.asarray(v, np.float64))
    size = 1e-6 * (1.0 + float(np.linalg.norm(np.asarray(v, np.float64))))
    assert rotate_vector(*q, *v) == pytest.approx(want, abs=size)
    assert rotate_vector_back(*q, *rotate_vector(*q, *v)) == pytest.approx(v, abs=2 * size)


@given(angles, st.floats(-1.5, 1.5, width=32), angles)
def test_quaternion_of_euler_angles(yaw, pitch, roll):
    assert same_rotation(quaternion_of_euler(yaw, pitch, roll), tait_bryan(yaw, pitch, roll))


@given(unit_quaternions())
def test_euler_angles_describe_the_same_rotation(q):
    yaw, pitch, roll = euler_of_quaternion(*q)
    assert same_rotation(q, tait_bryan(yaw, pitch, roll), 2e-4)
    assert 0.0 <= yaw < TWO_PI_32
    assert abs(pitch) <= np.float32(math.pi / 2)
    assert abs(roll) <= np.float32(math.pi)


@pytest.mark.parametrize("yaw", np.arange(0.0, 6.2, 0.61))
@pytest.mark.parametrize("pitch", [-1.57, -1.0, -0.3, 0.0, 0.8, 1.55])
@pytest.mark.parametrize("roll", [-3.1, -1.6, 0.0, 0.4, 2.0, 3.1])
def test_euler_angles_come_back(yaw, pitch, roll):
    got = euler_of_quaternion(*quaternion_of_euler(yaw, pitch, roll))
    turned = [math.remainder(a - b, 2 * math.pi) for a, b in zip(got, (yaw, pitch, roll), strict=True)]
    assert turned == pytest.approx([0.0, 0.0, 0.0], abs=4e-7 / math.cos(pitch) + 4e-7)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("yaw", "roll"), [(0.3, 0.0), (1.0, 0.5), (4.0, -2.0)])
def test_at_gimbal_lock_roll_is_zero_and_yaw_holds_the_rest(sign, yaw, roll):
    got_yaw, pitch, got_roll = euler_of_quaternion(*quaternion_of_euler(yaw, sign * math.pi / 2, roll))
    assert got_roll == 0.0
    assert pitch == pytest.approx(sign * math.pi / 2, abs=2e-4)
    assert math.remainder(got_yaw - (yaw - sign * roll), 2 * math.pi) == pytest.approx(0.0, abs=1e-6)


def test_beside_gimbal_lock_the_rotation_is_kept():
    for pitch in (math.pi / 2 - 2e-4, math.pi / 2 - 5e-5, -math.pi / 2 + 2e-4):
        q = quaternion_of_euler(1.0, pitch, 0.5)
        assert same_rotation(q, tait_bryan(*euler_of_quaternion(*q)), 3e-4)


@pytest.mark.parametrize("angle", [0.0, -1e-9, -1.0, 6.2831850, 6.2831855, 7.0, -6.2, 12.5])
def test_heading_is_within_a_turn_and_the_same_direction(angle):
    got = wrap_heading(angle)
    assert 0.0 <= got < TWO_PI_32
    assert math.remainder(got - float(np.float32(angle)), 2 * math.pi) == pytest.approx(0.0, abs=1e-6)
