"""The document's two other updates, for comparison only: Euler angles (2-9) and direction cosines (2-10).

Both by the same Runge-Kutta formula over three rates as the quaternion; the attitude is kept as q_nb between
iterations, so that the rest of the loop does not care. Euler angles stop being defined at pitch ±90°: there
the cosine is held off zero and the attitude is wrong, which is what the document says of them.
"""

import math

import numpy as np

from firmware.nav.attitude.updates import to_length_one
from firmware.numerics.dialect import kernel
from firmware.numerics.quaternion import euler_of_quaternion, quaternion_of_euler, rotation_matrix
from firmware.numerics.trigonometry import sine_cosine

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
QUARTER = np.float32(0.25)
SIXTH = np.float32(1.0 / 6.0)
LEAST_COS_PITCH = np.float32(1.0e-3)
SMALLEST = np.float32(1.0e-20)


@kernel
def euler_rates(pitch, roll, wx, wy, wz):
    """Derivatives of yaw, pitch and roll at rates ω_nb (2-9)."""
    sp, cp = sine_cosine(pitch)
    sr, cr = sine_cosine(roll)
    if abs(cp) < LEAST_COS_PITCH:
        cp = np.float32(math.copysign(LEAST_COS_PITCH, cp))
    turn = (wy * sr + wz * cr) / cp
    return turn, wy * cr - wz * sr, wx + turn * sp


@kernel
def by_euler_angles(period, w, x, y, z, ax, ay, az, bx, by, bz, cx, cy, cz):
    """q_nb by way of yaw, pitch and roll."""
    yaw, pitch, roll = euler_of_quaternion(w, x, y, z)
    h = HALF * period
    y1, p1, r1 = euler_rates(pitch, roll, ax, ay, az)
    y2, p2, r2 = euler_rates(pitch + h * p1, roll + h * r1, bx, by, bz)
    y3, p3, r3 = euler_rates(pitch + h * p2, roll + h * r2, bx, by, bz)
    y4, p4, r4 = euler_rates(pitch + period * p3, roll + period * r3, cx, cy, cz)
    t = SIXTH * period
    return quaternion_of_euler(
        yaw + t * (y1 + TWO * (y2 + y3) + y4),
        pitch + t * (p1 + TWO * (p2 + p3) + p4),
        roll + t * (r1 + TWO * (r2 + r3) + r4),
    )


@kernel
def cross(ax, ay, az, bx, by, bz):
    """a × b."""
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@kernel
def turned_row(period, x, y, z, ax, ay, az, bx, by, bz, cx, cy, cz):
    """One row r of C_n_b after an iteration of ṙ = r × ω (2-10)."""
    h = HALF * period
    kx, ky, kz = cross(x, y, z, ax, ay, az)
    lx, ly, lz = cross(x + h * kx, y + h * ky, z + h * kz, bx, by, bz)
    mx, my, mz = cross(x + h * lx, y + h * ly, z + h * lz, bx, by, bz)
    nx, ny, nz = cross(x + period * mx, y + period * my, z + period * mz, cx, cy, cz)
    t = SIXTH * period
    return (
        x + t * (kx + TWO * (lx + mx) + nx),
        y + t * (ky + TWO * (ly + my) + ny),
        z + t * (kz + TWO * (lz + mz) + nz),
    )


@kernel
def by_direction_cosines(period, w, x, y, z, ax, ay, az, bx, by, bz, cx, cy, cz):
    """q_nb by way of the nine direction cosines."""
    c00, c01, c02, c10, c11, c12, c20, c21, c22 = rotation_matrix(w, x, y, z)
    c00, c01, c02 = turned_row(period, c00, c01, c02, ax, ay, az, bx, by, bz, cx, cy, cz)
    c10, c11, c12 = turned_row(period, c10, c11, c12, ax, ay, az, bx, by, bz, cx, cy, cz)
    c20, c21, c22 = turned_row(period, c20, c21, c22, ax, ay, az, bx, by, bz, cx, cy, cz)
    return quaternion_of_matrix(c00, c01, c02, c10, c11, c12, c20, c21, c22)


@kernel
def quaternion_of_matrix(c00, c01, c02, c10, c11, c12, c20, c21, c22):
    """q_nb of C_n_b, by its largest element (2-22, 2-23)."""
    w2 = ONE + c00 + c11 + c22
    x2 = ONE + c00 - c11 - c22
    y2 = ONE - c00 + c11 - c22
    z2 = ONE - c00 - c11 + c22
    largest = max(max(w2, x2), max(y2, z2))
    root = np.float32(math.sqrt(max(largest, SMALLEST)))
    main = HALF * root
    rest = HALF / root
    if largest == w2:
        w, x, y, z = main, (c21 - c12) * rest, (c02 - c20) * rest, (c10 - c01) * rest
    elif largest == x2:
        w, x, y, z = (c21 - c12) * rest, main, (c10 + c01) * rest, (c02 + c20) * rest
    elif largest == y2:
        w, x, y, z = (c02 - c20) * rest, (c10 + c01) * rest, main, (c21 + c12) * rest
    else:
        w, x, y, z = (c10 - c01) * rest, (c02 + c20) * rest, (c21 + c12) * rest, main
    return to_length_one(w, x, y, z)
