"""One iteration of the attitude quaternion from the rates at t, t + T/2 and t + T.

Rates are those relative to n, in body axes; T is the iteration. All return q_nb at t + T, of length 1.

    RK4               q̇ = ½ q ⊗ ω, classical, with the middle rate in both middle stages      (source, 2-37)
    rotation vector   Δθ = T/6 (ω₀ + 4 ω₁ + ω₂), q ⊗ exp(Δθ/2) cut off after order 1 … 4   (2-33 … 2-36)
    two samples       α = ∫ over each half of the parabola through the rates,
                      φ = α₁ + α₂ + ⅔ α₁ × α₂: the coning that a sum of angles does not see
                      (R. Miller, A new strapdown attitude algorithm, JGCD 6 (1983))

Source: the thesis on the attitude computer of a small unmanned aircraft, chapter 2.
"""

import numpy as np

from firmware.numerics.dialect import kernel
from firmware.numerics.quaternion import quaternion_of_rotation, quaternion_product

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
FOUR = np.float32(4.0)
FIVE = np.float32(5.0)
EIGHT = np.float32(8.0)
THREE_HALVES = np.float32(1.5)
SIXTH = np.float32(1.0 / 6.0)
TWO_THIRDS = np.float32(2.0 / 3.0)
PER_24 = np.float32(1.0 / 24.0)
PER_8 = np.float32(1.0 / 8.0)
PER_48 = np.float32(1.0 / 48.0)
PER_384 = np.float32(1.0 / 384.0)


@kernel
def to_length_one(w, x, y, z):
    """The quaternion whose length is near 1, brought to it by a Newton step (within e²·⅜ of an error e)."""
    scale = THREE_HALVES - HALF * (w * w + x * x + y * y + z * z)
    return w * scale, x * scale, y * scale, z * scale


@kernel
def half_angles(period, ax, ay, az, bx, by, bz, cx, cy, cz):
    """Angles over the first and the second half of the iteration, of the parabola through three rates."""
    h = period * PER_24
    return (
        h * (FIVE * ax + EIGHT * bx - cx),
        h * (FIVE * ay + EIGHT * by - cy),
        h * (FIVE * az + EIGHT * bz - cz),
        h * (EIGHT * bx + FIVE * cx - ax),
        h * (EIGHT * by + FIVE * cy - ay),
        h * (EIGHT * bz + FIVE * cz - az),
    )


@kernel
def by_runge_kutta(period, w, x, y, z, ax, ay, az, bx, by, bz, cx, cy, cz):
    """The document's update; K are the derivatives times T."""
    h = HALF * period
    ax, ay, az = h * ax, h * ay, h * az
    bx, by, bz = h * bx, h * by, h * bz
    cx, cy, cz = h * cx, h * cy, h * cz
    kw, kx, ky, kz = quaternion_product(w, x, y, z, ZERO, ax, ay, az)
    sw, sx, sy, sz = kw, kx, ky, kz
    kw, kx, ky, kz = quaternion_product(
        w + HALF * kw, x + HALF * kx, y + HALF * ky, z + HALF * kz, ZERO, bx, by, bz
    )
    sw, sx, sy, sz = sw + TWO * kw, sx + TWO * kx, sy + TWO * ky, sz + TWO * kz
    kw, kx, ky, kz = quaternion_product(
        w + HALF * kw, x + HALF * kx, y + HALF * ky, z + HALF * kz, ZERO, bx, by, bz
    )
    sw, sx, sy, sz = sw + TWO * kw, sx + TWO * kx, sy + TWO * ky, sz + TWO * kz
    kw, kx, ky, kz = quaternion_product(w + kw, x + kx, y + ky, z + kz, ZERO, cx, cy, cz)
    return to_length_one(
        w + SIXTH * (sw + kw), x + SIXTH * (sx + kx), y + SIXTH * (sy + ky), z + SIXTH * (sz + kz)
    )


@kernel
def by_rotation_vector(order, w, x, y, z, tx, ty, tz):
    """Turn by the sum of angles Δθ, the exponential cut off after `order` (1 … 4)."""
    square = tx * tx + ty * ty + tz * tz
    scalar = ONE
    vector = HALF
    if order >= 2:
        scalar -= PER_8 * square
    if order >= 3:
        vector -= PER_48 * square
    if order >= 4:
        scalar += PER_384 * square * square
    return normalised_product(w, x, y, z, scalar, vector * tx, vector * ty, vector * tz)


@kernel
def normalised_product(w, x, y, z, bw, bx, by, bz):
    """q ⊗ b, of length 1."""
    w, x, y, z = quaternion_product(w, x, y, z, bw, bx, by, bz)
    return to_length_one(w, x, y, z)


@kernel
def by_two_samples(w, x, y, z, px, py, pz, qx, qy, qz):
    """Turn by the rotation vector of the angles p and q of the two halves."""
    bw, bx, by, bz = quaternion_of_rotation(
        px + qx + TWO_THIRDS * (py * qz - pz * qy),
        py + qy + TWO_THIRDS * (pz * qx - px * qz),
        pz + qz + TWO_THIRDS * (px * qy - py * qx),
    )
    return normalised_product(w, x, y, z, bw, bx, by, bz)
