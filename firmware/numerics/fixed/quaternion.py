"""Attitude quaternions and direction cosines in Q30, the conventions of `firmware.numerics.quaternion`.

Angles are binary. A component of a unit quaternion or matrix is at most 1 and a few units; ±2 is the end of
Q30. Each result is rounded once (5e-10 of 1).
"""

import numpy as np

from firmware.numerics.dialect import kernel
from firmware.numerics.fixed.angles import (
    ONE_Q30,
    ONE_Q60,
    arc_tangent2,
    sine_cosine,
)
from firmware.numerics.fixed.arithmetic import in_q, leading_bit, product, rounded_shift
from firmware.numerics.fixed.roots import reciprocal_mantissa, square_root

GIMBAL_LOCK_COS_PITCH = in_q(1.0e-4, 30)


@kernel
def quaternion_product(aw, ax, ay, az, bw, bx, by, bz, bits):
    """a ⊗ b, shifted down by `bits`; |a| |b| < 2⁶²."""
    return (
        rounded_shift(aw * bw - ax * bx - ay * by - az * bz, bits),
        rounded_shift(aw * bx + ax * bw + ay * bz - az * by, bits),
        rounded_shift(aw * by - ax * bz + ay * bw + az * bx, bits),
        rounded_shift(aw * bz + ax * by - ay * bx + az * bw, bits),
    )


@kernel
def to_length_one(w, x, y, z):
    """The quaternion whose length is near 1, brought to it by a Newton step; components below 1.4."""
    missing = rounded_shift(ONE_Q60 - w * w - x * x - y * y - z * z, 30)
    return (
        w + product(w, missing, 31),
        x + product(x, missing, 31),
        y + product(y, missing, 31),
        z + product(z, missing, 31),
    )


@kernel("UniTuple(int64, 9)(int64, int64, int64, int64)")
def rotation_matrix(w, x, y, z):
    """C, row by row, in Q30."""
    return (
        ONE_Q30 - rounded_shift(y * y + z * z, 29),
        rounded_shift(x * y - w * z, 29),
        rounded_shift(x * z + w * y, 29),
        rounded_shift(x * y + w * z, 29),
        ONE_Q30 - rounded_shift(x * x + z * z, 29),
        rounded_shift(y * z - w * x, 29),
        rounded_shift(x * z - w * y, 29),
        rounded_shift(y * z + w * x, 29),
        ONE_Q30 - rounded_shift(x * x + y * y, 29),
    )


@kernel("UniTuple(int64, 4)(int64, int64, int64)")
def quaternion_of_euler(yaw, pitch, roll):
    """q_nb of binary angles."""
    sy, cy = _half(yaw)
    sp, cp = _half(pitch)
    sr, cr = _half(roll)
    cc = product(cp, cr, 30)
    ss = product(sp, sr, 30)
    cs = product(cp, sr, 30)
    sc = product(sp, cr, 30)
    return to_length_one(
        rounded_shift(cy * cc + sy * ss, 30),
        rounded_shift(cy * cs - sy * sc, 30),
        rounded_shift(cy * sc + sy * cs, 30),
        rounded_shift(sy * cc - cy * ss, 30),
    )


@kernel
def _half(angle):
    """Sine and cosine of half a binary angle."""
    return sine_cosine(rounded_shift(angle, 1))


@kernel("UniTuple(int64, 3)(int64, int64, int64, int64)")
def euler_of_quaternion(w, x, y, z):
    """Binary (yaw, pitch, roll) of the unit quaternion; at gimbal lock roll is 0, yaw holds the rest."""
    c11, c12, _, c21, c22, _, c31, c32, c33 = rotation_matrix(w, x, y, z)
    cos_pitch = square_root(c11 * c11 + c21 * c21)
    pitch = arc_tangent2(-c31, cos_pitch)
    if cos_pitch < GIMBAL_LOCK_COS_PITCH:
        return arc_tangent2(-c12, c22), pitch, np.int64(0)
    roll = arc_tangent2(c32, c33)
    return arc_tangent2(c21, c11), pitch, roll


@kernel
def quaternion_of_matrix(c00, c01, c02, c10, c11, c12, c20, c21, c22):
    """q_nb of C_n_b, by its largest element."""
    w2 = ONE_Q30 + c00 + c11 + c22
    x2 = ONE_Q30 + c00 - c11 - c22
    y2 = ONE_Q30 - c00 + c11 - c22
    z2 = ONE_Q30 - c00 - c11 + c22
    largest = max(max(w2, x2), max(y2, z2))
    root = square_root(largest << 30)  # 1 … 2 in Q30
    main = rounded_shift(root, 1)
    e = leading_bit(root)
    rest = reciprocal_mantissa(root << 30 - e if e <= 30 else root >> 1)  # 2^(e + 31)/root
    bits = e + 2
    if largest == w2:
        w, x, y, z = (
            main,
            product(c21 - c12, rest, bits),
            product(c02 - c20, rest, bits),
            product(c10 - c01, rest, bits),
        )
    elif largest == x2:
        w, x, y, z = (
            product(c21 - c12, rest, bits),
            main,
            product(c10 + c01, rest, bits),
            product(c02 + c20, rest, bits),
        )
    elif largest == y2:
        w, x, y, z = (
            product(c02 - c20, rest, bits),
            product(c10 + c01, rest, bits),
            main,
            product(c21 + c12, rest, bits),
        )
    else:
        w, x, y, z = (
            product(c10 - c01, rest, bits),
            product(c02 + c20, rest, bits),
            product(c21 + c12, rest, bits),
            main,
        )
    return to_length_one(w, x, y, z)
