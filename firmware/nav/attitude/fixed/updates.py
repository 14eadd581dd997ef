"""One iteration of the attitude quaternion in fixed point; the formulas are those of `..updates`.

Rates in Q27 rad/s, angles in Q32 rad, the quaternion in Q30, T/2 in Q37 s; a quaternion of a small turn has
its scalar in Q30 and its vector, half an angle, in Q32. The updates give q_nb in Q38: its Q30 part is what
the next iteration turns, the rest is carried, so that a rate far below a unit an iteration still turns it.
"""

from firmware.nav.attitude import flags as fl
from firmware.nav.attitude.fixed import layout as at
from firmware.nav.attitude.fixed.samples import store
from firmware.numerics.dialect import kernel
from firmware.numerics.fixed.angles import ONE_Q30, ONE_Q60
from firmware.numerics.fixed.arithmetic import in_q, limited, product, rounded_shift
from firmware.numerics.fixed.quaternion import quaternion_product

SIXTH = in_q(1.0 / 6.0, 31)
TWELFTH = in_q(1.0 / 12.0, 31)
TWO_THIRDS = in_q(2.0 / 3.0, 31)
PER_48 = in_q(1.0 / 48.0, 35)
PER_384 = in_q(1.0 / 384.0, 38)
PER_3840 = in_q(1.0 / 3840.0, 42)
PER_46080 = in_q(1.0 / 46080.0, 46)
PER_645120 = in_q(1.0 / 645120.0, 50)
HALF = ONE_Q30 >> 1
LARGEST_HALF_ANGLE = in_q(0.2, 32)
"""rad over half an iteration: three sums of two of them still square within 63 bits."""


@kernel
def half_angle(half_period, i, twelve_means):
    """Angle of half an iteration from twelve times its mean rate."""
    mean = product(twelve_means, TWELFTH, 31)
    angle = product(mean, half_period, at.Q_RATE + at.Q_HALF_PERIOD - at.Q_ANGLE)
    return limited(angle, LARGEST_HALF_ANGLE, i, at.SATURATIONS + fl.SATURATED_ANGLE)


@kernel
def half_angles(half_period, i, ax, ay, az, bx, by, bz, cx, cy, cz):
    """Angles over the first and the second half of the iteration, of the parabola through three rates."""
    return (
        half_angle(half_period, i, 5 * ax + 8 * bx - cx),
        half_angle(half_period, i, 5 * ay + 8 * by - cy),
        half_angle(half_period, i, 5 * az + 8 * bz - cz),
        half_angle(half_period, i, 8 * bx + 5 * cx - ax),
        half_angle(half_period, i, 8 * by + 5 * cy - ay),
        half_angle(half_period, i, 8 * bz + 5 * cz - az),
    )


@kernel
def turning(rate, half_period):
    """ω T/2 in Q32."""
    return product(rate, half_period, at.Q_RATE + at.Q_HALF_PERIOD - at.Q_ANGLE)


@kernel
def moved(a, k, bits):
    """A component in Q30 and a change of it in Q(30 + bits)."""
    return a + rounded_shift(k, bits)


@kernel
def by_runge_kutta(half_period, w, x, y, z, ax, ay, az, bx, by, bz, cx, cy, cz):
    """The document's update; k are the derivatives times T, in Q32."""
    ax, ay, az = turning(ax, half_period), turning(ay, half_period), turning(az, half_period)
    bx, by, bz = turning(bx, half_period), turning(by, half_period), turning(bz, half_period)
    cx, cy, cz = turning(cx, half_period), turning(cy, half_period), turning(cz, half_period)
    kw, kx, ky, kz = quaternion_product(w, x, y, z, 0, ax, ay, az, 30)
    sw, sx, sy, sz = kw, kx, ky, kz
    kw, kx, ky, kz = quaternion_product(
        moved(w, kw, 3), moved(x, kx, 3), moved(y, ky, 3), moved(z, kz, 3), 0, bx, by, bz, 30
    )
    sw, sx, sy, sz = sw + 2 * kw, sx + 2 * kx, sy + 2 * ky, sz + 2 * kz
    kw, kx, ky, kz = quaternion_product(
        moved(w, kw, 3), moved(x, kx, 3), moved(y, ky, 3), moved(z, kz, 3), 0, bx, by, bz, 30
    )
    sw, sx, sy, sz = sw + 2 * kw, sx + 2 * kx, sy + 2 * ky, sz + 2 * kz
    kw, kx, ky, kz = quaternion_product(
        moved(w, kw, 2), moved(x, kx, 2), moved(y, ky, 2), moved(z, kz, 2), 0, cx, cy, cz, 30
    )
    return (
        (w << 8) + product(sw + kw, SIXTH, 25),
        (x << 8) + product(sx + kx, SIXTH, 25),
        (y << 8) + product(sy + ky, SIXTH, 25),
        (z << 8) + product(sz + kz, SIXTH, 25),
    )


@kernel
def turn_by(w, x, y, z, scalar, vx, vy, vz):
    """q ⊗ (scalar in Q30, vector in Q32)."""
    return (
        rounded_shift(((w * scalar) << 2) - x * vx - y * vy - z * vz, 24),
        rounded_shift(((x * scalar) << 2) + w * vx + y * vz - z * vy, 24),
        rounded_shift(((y * scalar) << 2) + w * vy + z * vx - x * vz, 24),
        rounded_shift(((z * scalar) << 2) + w * vz + x * vy - y * vx, 24),
    )


@kernel
def set_quaternion(s, i, w, x, y, z):
    """Keep q_nb, given in Q38 and of a length near 1, with length 1: in QUATERNION and what that leaves over.

    One Newton step; what the length is wrong by is known to a unit of Q30, which turns nothing.
    """
    w += i[at.QUATERNION_REST]
    x += i[at.QUATERNION_REST + 1]
    y += i[at.QUATERNION_REST + 2]
    z += i[at.QUATERNION_REST + 3]
    p, q, r, t = rounded_shift(w, 8), rounded_shift(x, 8), rounded_shift(y, 8), rounded_shift(z, 8)
    missing = rounded_shift(ONE_Q60 - p * p - q * q - r * r - t * t, 30)
    keep_component(s, i, 0, w + product(p, missing, 23))
    keep_component(s, i, 1, x + product(q, missing, 23))
    keep_component(s, i, 2, y + product(r, missing, 23))
    keep_component(s, i, 3, z + product(t, missing, 23))


@kernel
def keep_component(s, i, k, value):
    """One component in Q38."""
    whole = rounded_shift(value, at.Q_FINE - at.Q_UNIT)
    i[at.QUATERNION_REST + k] = value - (whole << (at.Q_FINE - at.Q_UNIT))
    store(s, i, at.QUATERNION + k, fl.SATURATED_ATTITUDE, whole)


@kernel
def square_of(tx, ty, tz):
    """|θ|² in Q30."""
    return rounded_shift(tx * tx + ty * ty + tz * tz, 34)


@kernel
def by_rotation_vector(order, w, x, y, z, tx, ty, tz):
    """Turn by the sum of angles Δθ, the exponential cut off after `order` (1 … 4)."""
    square = square_of(tx, ty, tz)
    scalar = ONE_Q30
    vector = HALF
    if order >= 2:
        scalar -= rounded_shift(square, 3)
    if order >= 3:
        vector -= product(square, PER_48, 35)
    if order >= 4:
        scalar += product(product(square, square, 30), PER_384, 38)
    return turn_by(
        w, x, y, z, scalar, product(vector, tx, 30), product(vector, ty, 30), product(vector, tz, 30)
    )


@kernel
def by_two_samples(w, x, y, z, px, py, pz, qx, qy, qz):
    """Turn by the rotation vector of the angles p and q of the two halves."""
    tx = px + qx + product(rounded_shift(py * qz - pz * qy, 32), TWO_THIRDS, 31)
    ty = py + qy + product(rounded_shift(pz * qx - px * qz, 32), TWO_THIRDS, 31)
    tz = pz + qz + product(rounded_shift(px * qy - py * qx, 32), TWO_THIRDS, 31)
    square = square_of(tx, ty, tz)
    fourth = product(square, square, 30)
    sixth = product(fourth, square, 30)
    scalar = ONE_Q30 - rounded_shift(square, 3) + product(fourth, PER_384, 38) - product(sixth, PER_46080, 46)
    vector = (
        HALF - product(square, PER_48, 35) + product(fourth, PER_3840, 42) - product(sixth, PER_645120, 50)
    )
    return turn_by(
        w, x, y, z, scalar, product(vector, tx, 30), product(vector, ty, 30), product(vector, tz, 30)
    )
