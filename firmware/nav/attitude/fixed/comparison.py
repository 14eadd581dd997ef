"""The document's updates by Euler angles and direction cosines in fixed point, for comparison only.

The formulas are those of `..comparison`. Rates in Q27 rad/s, angles binary, direction cosines in Q30.
"""

import numpy as np

from firmware.nav.attitude import flags as fl
from firmware.nav.attitude.fixed import layout as at
from firmware.nav.attitude.fixed.updates import SIXTH, turning
from firmware.numerics.dialect import kernel
from firmware.numerics.fixed.angles import sine_cosine
from firmware.numerics.fixed.arithmetic import LARGEST, in_q, limited, product, rounded_shift, saturated
from firmware.numerics.fixed.quaternion import (
    euler_of_quaternion,
    quaternion_of_euler,
    quaternion_of_matrix,
    rotation_matrix,
)
from firmware.numerics.fixed.roots import quotient

LEAST_COS_PITCH = in_q(1.0e-3, 30)
THIRD = in_q(1.0 / 3.0, 31)


@kernel
def euler_rates(i, pitch, roll, wx, wy, wz):
    """Derivatives of yaw, pitch and roll in Q27; beyond it they saturate and are counted."""
    counter = at.SATURATIONS + fl.SATURATED_ANGLE
    sp, cp = sine_cosine(pitch)
    sr, cr = sine_cosine(roll)
    across = limited(rounded_shift(wy * sr + wz * cr, 30), np.int64(LARGEST), i, counter)
    turn = quotient(across, max(abs(cp), np.int64(LEAST_COS_PITCH)), 30)
    turn = saturated(-turn if cp < 0 else turn, i, counter)
    return (
        turn,
        saturated(rounded_shift(wy * cr - wz * sr, 30), i, counter),
        saturated(wx + product(turn, sp, 30), i, counter),
    )


@kernel
def mean_turn(turn_period, first, second, third, fourth):
    """Binary angle of an iteration from the four derivatives of Runge and Kutta."""
    return product(
        product(first + 2 * (second + third) + fourth, SIXTH, 31), turn_period, at.Q_TURN_PERIOD - 1
    )


@kernel
def by_euler_angles(s, i, w, x, y, z, ax, ay, az, bx, by, bz, cx, cy, cz):
    """q_nb in Q38 by way of yaw, pitch and roll."""
    yaw, pitch, roll = euler_of_quaternion(w, x, y, z)
    t = np.int64(s[at.TURN_PERIOD])
    q = at.Q_TURN_PERIOD
    y1, p1, r1 = euler_rates(i, pitch, roll, ax, ay, az)
    y2, p2, r2 = euler_rates(i, pitch + product(p1, t, q), roll + product(r1, t, q), bx, by, bz)
    y3, p3, r3 = euler_rates(i, pitch + product(p2, t, q), roll + product(r2, t, q), bx, by, bz)
    y4, p4, r4 = euler_rates(i, pitch + product(p3, t, q - 1), roll + product(r3, t, q - 1), cx, cy, cz)
    w, x, y, z = quaternion_of_euler(
        yaw + mean_turn(t, y1, y2, y3, y4),
        pitch + mean_turn(t, p1, p2, p3, p4),
        roll + mean_turn(t, r1, r2, r3, r4),
    )
    return w << 8, x << 8, y << 8, z << 8


@kernel
def cross(ax, ay, az, bx, by, bz, bits):
    """a × b, shifted down."""
    return (
        rounded_shift(ay * bz - az * by, bits),
        rounded_shift(az * bx - ax * bz, bits),
        rounded_shift(ax * by - ay * bx, bits),
    )


@kernel
def turned_row(x, y, z, ax, ay, az, bx, by, bz, cx, cy, cz):
    """One row r of C_n_b after an iteration of ṙ = r × ω, with the angles ω T/2 in Q32."""
    kx, ky, kz = cross(x, y, z, ax, ay, az, 30)
    lx, ly, lz = cross(
        x + rounded_shift(kx, 2), y + rounded_shift(ky, 2), z + rounded_shift(kz, 2), bx, by, bz, 30
    )
    mx, my, mz = cross(
        x + rounded_shift(lx, 2), y + rounded_shift(ly, 2), z + rounded_shift(lz, 2), bx, by, bz, 30
    )
    nx, ny, nz = cross(
        x + rounded_shift(mx, 1), y + rounded_shift(my, 1), z + rounded_shift(mz, 1), cx, cy, cz, 30
    )
    return (
        x + product(kx + 2 * (lx + mx) + nx, THIRD, 33),
        y + product(ky + 2 * (ly + my) + ny, THIRD, 33),
        z + product(kz + 2 * (lz + mz) + nz, THIRD, 33),
    )


@kernel
def by_direction_cosines(half_period, w, x, y, z, ax, ay, az, bx, by, bz, cx, cy, cz):
    """q_nb in Q38 by way of the nine direction cosines."""
    ax, ay, az = turning(ax, half_period), turning(ay, half_period), turning(az, half_period)
    bx, by, bz = turning(bx, half_period), turning(by, half_period), turning(bz, half_period)
    cx, cy, cz = turning(cx, half_period), turning(cy, half_period), turning(cz, half_period)
    c00, c01, c02, c10, c11, c12, c20, c21, c22 = rotation_matrix(w, x, y, z)
    c00, c01, c02 = turned_row(c00, c01, c02, ax, ay, az, bx, by, bz, cx, cy, cz)
    c10, c11, c12 = turned_row(c10, c11, c12, ax, ay, az, bx, by, bz, cx, cy, cz)
    c20, c21, c22 = turned_row(c20, c21, c22, ax, ay, az, bx, by, bz, cx, cy, cz)
    w, x, y, z = quaternion_of_matrix(c00, c01, c02, c10, c11, c12, c20, c21, c22)
    return w << 8, x << 8, y << 8, z << 8
