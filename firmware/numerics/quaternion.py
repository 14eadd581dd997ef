"""Attitude quaternions q = (w, x, y, z), scalar first, Hamilton product, in float32.

q_nb turns body axes to navigation axes: v_n = q_nb ⊗ v_b ⊗ q_nb*, C_n_b = rotation_matrix(q_nb). A rotation φ
of the body (rad, seen in body axes) multiplies from the right: q_nb ⊗ quaternion_of_rotation(φ_b).
Euler angles are Z-Y-X: yaw from north to east in [0, 2π), pitch nose up in [−π/2, π/2], roll right side down
in (−π, π]. See Titterton & Weston, Strapdown Inertial Navigation Technology, 2nd ed., section 3.6.

Everything goes in and out as scalars, so that a caller keeps its quaternion wherever it likes in its flat
array; the calls are compiled into the caller and cost nothing.
"""

import math

import numpy as np

from firmware.numerics.dialect import kernel
from firmware.numerics.trigonometry import arc_tangent2, sine_cosine

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
TWO_PI = np.float32(6.28318530717959)

# Below half an angle of 0.25 rad, four terms of the series are exact to float32 (next one: 4e-10).
SERIES_BELOW = np.float32(0.0625)
SIN_3 = np.float32(1.0 / 6.0)
SIN_5 = np.float32(1.0 / 120.0)
SIN_7 = np.float32(1.0 / 5040.0)
COS_4 = np.float32(1.0 / 24.0)
COS_6 = np.float32(1.0 / 720.0)

# Within 0.006° of the vertical, yaw and roll turn about one axis: only their sum or difference is known.
GIMBAL_LOCK_COS_PITCH = np.float32(1.0e-4)


@kernel("UniTuple(float32, 4)(float32, float32, float32, float32, float32, float32, float32, float32)")
def quaternion_product(aw, ax, ay, az, bw, bx, by, bz):
    """a ⊗ b: the rotation b, then a."""
    w = aw * bw - ax * bx - ay * by - az * bz
    x = aw * bx + ax * bw + ay * bz - az * by
    y = aw * by - ax * bz + ay * bw + az * bx
    z = aw * bz + ax * by - ay * bx + az * bw
    return w, x, y, z


@kernel("UniTuple(float32, 4)(float32, float32, float32, float32)")
def normalise_quaternion(w, x, y, z):
    """The quaternion of length 1 in the same direction; no rotation (1, 0, 0, 0) for a zero one."""
    square = w * w + x * x + y * y + z * z
    if square == ZERO:
        return ONE, ZERO, ZERO, ZERO
    length = np.float32(math.sqrt(square))
    return w / length, x / length, y / length, z / length


@kernel("UniTuple(float32, 4)(float32, float32, float32)")
def quaternion_of_rotation(x, y, z):
    """Quaternion of the rotation vector (x, y, z) in rad, of any length."""
    quarter_square = (x * x + y * y + z * z) * HALF * HALF
    if quarter_square < SERIES_BELOW:
        u = quarter_square
        w = ONE - u * (HALF - u * (COS_4 - u * COS_6))
        scale = HALF * (ONE - u * (SIN_3 - u * (SIN_5 - u * SIN_7)))
    else:
        half_angle = np.float32(math.sqrt(quarter_square))
        s, w = sine_cosine(half_angle)
        scale = HALF * s / half_angle
    return w, x * scale, y * scale, z * scale


@kernel("UniTuple(float32, 9)(float32, float32, float32, float32)")
def rotation_matrix(w, x, y, z):
    """C, row by row, of a unit quaternion: v_n = C_n_b v_b for q_nb."""
    xx = x * x
    yy = y * y
    zz = z * z
    xy = x * y
    xz = x * z
    yz = y * z
    wx = w * x
    wy = w * y
    wz = w * z
    return (
        ONE - TWO * (yy + zz),
        TWO * (xy - wz),
        TWO * (xz + wy),
        TWO * (xy + wz),
        ONE - TWO * (xx + zz),
        TWO * (yz - wx),
        TWO * (xz - wy),
        TWO * (yz + wx),
        ONE - TWO * (xx + yy),
    )


@kernel("UniTuple(float32, 3)(float32, float32, float32, float32, float32, float32, float32)")
def rotate_vector(w, x, y, z, vx, vy, vz):
    """q ⊗ v ⊗ q*: for q_nb, a vector in body axes to navigation axes. v + 2 q⃗ × (q⃗ × v + w v)."""
    tx = y * vz - z * vy + w * vx
    ty = z * vx - x * vz + w * vy
    tz = x * vy - y * vx + w * vz
    return (
        vx + TWO * (y * tz - z * ty),
        vy + TWO * (z * tx - x * tz),
        vz + TWO * (x * ty - y * tx),
    )


@kernel("UniTuple(float32, 3)(float32, float32, float32, float32, float32, float32, float32)")
def rotate_vector_back(w, x, y, z, vx, vy, vz):
    """q* ⊗ v ⊗ q: for q_nb, a vector in navigation axes to body axes."""
    return rotate_vector(w, -x, -y, -z, vx, vy, vz)


@kernel("UniTuple(float32, 4)(float32, float32, float32)")
def quaternion_of_euler(yaw, pitch, roll):
    """q_nb of Z-Y-X Euler angles in rad."""
    sy, cy = sine_cosine(HALF * yaw)
    sp, cp = sine_cosine(HALF * pitch)
    sr, cr = sine_cosine(HALF * roll)
    return (
        cy * cp * cr + sy * sp * sr,
        cy * cp * sr - sy * sp * cr,
        cy * sp * cr + sy * cp * sr,
        sy * cp * cr - cy * sp * sr,
    )


@kernel("UniTuple(float32, 3)(float32, float32, float32, float32)")
def euler_of_quaternion(w, x, y, z):
    """(yaw, pitch, roll) in rad of the unit quaternion q_nb; at gimbal lock roll is 0, yaw holds the rest."""
    c11, c12, _, c21, c22, _, c31, c32, c33 = rotation_matrix(w, x, y, z)
    cos_pitch = np.float32(math.sqrt(c11 * c11 + c21 * c21))
    pitch = arc_tangent2(-c31, cos_pitch)
    if cos_pitch < GIMBAL_LOCK_COS_PITCH:
        roll = ZERO
        yaw = arc_tangent2(-c12, c22)
    else:
        roll = arc_tangent2(c32, c33)
        yaw = arc_tangent2(c21, c11)
    return wrap_heading(yaw), pitch, roll


@kernel("float32(float32)")
def wrap_heading(angle):
    """An angle in (−2π, 4π) rad brought into [0, 2π)."""
    if angle < ZERO:
        angle = angle + TWO_PI
    if angle >= TWO_PI:
        angle = angle - TWO_PI
    return angle
