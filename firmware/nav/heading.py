"""Yaw after a rest: from the course over ground, or given; and the watch over it later.

A course tells where the antenna goes, not where the nose points. After a rest the velocity gained since then,
integrated in the level axes n', tells whether the vehicle drives forward or backs out; backwards, yaw is the
course + 180°. The vehicle's axes may be turned in body axes by the mounting yaw, which begins at 0 with its
own uncertainty, and the error of the yaw found is tied to it (initial_covariance).

While navigating, a course that contradicts the yaw for some seconds at speed tells that yaw is wrong. A
course opposite to it is a vehicle that drives backwards as long as the velocity measured agrees with the
inertial one; with yaw itself turned round, the first acceleration goes the wrong way and the velocity is
refused.
"""

import math

import numpy as np

from firmware.drivers import gnss_epoch as gnss
from firmware.nav import layout as at
from firmware.nav import tuning as cfg
from firmware.nav.beginning import clear_parameters, enter_navigation, set_velocity_and_position
from firmware.nav.gnss_measurement import epoch_velocity
from firmware.nav.gnss_noise import speed_variance
from firmware.nav.history import look_up, seconds_between
from firmware.nav.initial_covariance import begin_covariance, correlate_tilt, correlate_yaw
from firmware.nav.strapdown import set_attitude
from firmware.numerics.dialect import kernel
from firmware.numerics.quaternion import (
    euler_of_quaternion,
    quaternion_of_rotation,
    quaternion_product,
    rotate_vector_back,
    wrap_heading,
)
from firmware.numerics.trigonometry import arc_tangent2, sine_cosine

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
HALF_PI = np.float32(1.57079632679490)
PI = np.float32(3.14159265358979)
THREE = np.int32(3)
TWO_PI = np.float32(6.28318530717959)
LEVEL_VARIANCE = np.float32(2.0e-3 * 2.0e-3)
"""Tilt read from the force at rest, besides the bias."""


@kernel
def wrap_pi(angle):
    """An angle in (−3π, 3π) brought into [−π, π)."""
    if angle >= PI:
        return angle - TWO_PI
    if angle < -PI:
        return angle + TWO_PI
    return angle


@kernel
def has_course(e):
    """Whether the epoch tells a direction of motion."""
    flags = e[gnss.FLAGS]
    if flags & gnss.HAS_VELOCITY:
        return True
    return (flags & gnss.HAS_SPEED) != 0 and (flags & gnss.HAS_COURSE) != 0


@kernel
def course_and_speed(e):
    """Direction of motion in rad and horizontal speed in m/s."""
    north, east, _ = epoch_velocity(e)
    square = north * north + east * east
    return arc_tangent2(east, north), np.float32(math.sqrt(square))


@kernel
def course_variance(f, e, speed):
    """Of a course at this speed, rad²."""
    return f[cfg.COURSE_VARIANCE] + speed_variance(f, e) / (speed * speed)


@kernel
def find_heading(f, i, e, time):
    """Levelled and waiting: begin navigation when this epoch (valid at `time`) tells yaw, or yaw is given."""
    if not look_up(f, i, time):
        return
    q = at.AGO_QUATERNION
    yaw_then, _, _ = euler_of_quaternion(f[q], f[q + 1], f[q + 2], f[q + 3])
    if i[cfg.YAW_IS_GIVEN] != 0:  # for the attitude that was levelled
        begin_after_rest(f, i, e, time, f[cfg.INITIAL_YAW], f[cfg.INITIAL_YAW_VARIANCE])
        f[at.AT_REST] = ONE if i[at.LEVEL_WINDOWS] > 0 else ZERO
        return
    if not has_course(e):
        return
    course, speed = course_and_speed(e)
    if not speed > f[cfg.HEADING_SPEED] or abs(f[at.AGO_RATE + 2]) > f[cfg.HEADING_MAX_RATE]:
        return
    forward, _, _ = rotate_vector_back(
        f[q], f[q + 1], f[q + 2], f[q + 3], f[at.AGO_VELOCITY], f[at.AGO_VELOCITY + 1], f[at.AGO_VELOCITY + 2]
    )
    if forward < -HALF * speed:
        course += PI
    begin_after_rest(f, i, e, time, course - yaw_then, course_variance(f, e, speed))
    correlate_yaw(f)


@kernel
def begin_after_rest(f, i, e, time, turn, yaw_variance):
    """Turn the level axes n' by `turn` to north and begin.

    The bias learnt at rest is noise as well; gyros known to be better than that noise keep their share.
    """
    dn, de, dd = _velocity_since(f, turn)
    _turn_quaternion(f, at.REST_QUATERNION, turn)
    _turn_quaternion(f, at.AGO_QUATERNION, turn)
    _turn_quaternion(f, at.QUATERNION, turn)
    q = at.QUATERNION
    set_attitude(f, f[q], f[q + 1], f[q + 2], f[q + 3])
    age = set_velocity_and_position(f, i, e, time, dn, de, dd)
    clear_parameters(f)
    r = at.REST_QUATERNION
    ex, ey, ez = rotate_vector_back(
        f[r], f[r + 1], f[r + 2], f[r + 3], f[at.EARTH_RATE_N], ZERO, f[at.EARTH_RATE_D]
    )
    f[at.GYRO_BIAS] = f[at.REST_RATE] - ex
    f[at.GYRO_BIAS + 1] = f[at.REST_RATE + 1] - ey
    f[at.GYRO_BIAS + 2] = f[at.REST_RATE + 2] - ez
    f[at.BIAS_TEMPERATURE] = f[at.REST_TEMPERATURE]
    since = seconds_between(i[at.LEVELLED_AT], i[at.TIME])
    gyro = f[cfg.REST_GYRO_VARIANCE] + f[cfg.ANGLE_WALK_VARIANCE] / f[at.REST_TIME]
    drift = gyro * since * since + f[cfg.ANGLE_WALK_VARIANCE] * since
    if f[cfg.GYRO_VARIANCE] > ZERO:
        share = f[cfg.GYRO_VARIANCE] / (f[cfg.GYRO_VARIANCE] + gyro)
        gyro *= share
        for k in range(THREE):
            f[at.GYRO_BIAS + k] *= share
    begin_covariance(f, e, age, LEVEL_VARIANCE + drift, yaw_variance + drift, gyro)
    correlate_tilt(f, f[r], f[r + 1], f[r + 2], f[r + 3])
    enter_navigation(f, i)


@kernel
def _turn_quaternion(f, place, angle):
    """Turn the navigation axes of the quaternion at `place`: its yaw grows by `angle`."""
    w, x, y, z = quaternion_of_rotation(ZERO, ZERO, angle)
    w, x, y, z = quaternion_product(w, x, y, z, f[place], f[place + 1], f[place + 2], f[place + 3])
    f[place] = w
    f[place + 1] = x
    f[place + 2] = y
    f[place + 3] = z


@kernel
def _velocity_since(f, turn):
    """How the velocity changed since the state looked up, in axes turned by `turn` about down."""
    s, c = sine_cosine(turn)
    dn = f[at.VELOCITY] - f[at.AGO_VELOCITY]
    de = f[at.VELOCITY + 1] - f[at.AGO_VELOCITY + 1]
    return c * dn - s * de, s * dn + c * de, f[at.VELOCITY + 2] - f[at.AGO_VELOCITY + 2]


@kernel
def heading_is_wrong(f, i, e, time):
    """Whether the course has contradicted yaw (state at `time` looked up) for longer than the limit."""
    if not has_course(e):
        return False
    course, speed = course_and_speed(e)
    if not speed > f[cfg.HEADING_CHECK_SPEED]:
        return False
    q = at.AGO_QUATERNION
    yaw, _, _ = euler_of_quaternion(f[q], f[q + 1], f[q + 2], f[q + 3])
    contradiction = abs(wrap_pi(course - wrap_heading(yaw + f[at.MOUNTING])))
    if contradiction > HALF_PI and i[at.VELOCITY_REFUSED_SINCE] == at.NEVER:
        contradiction = PI - contradiction
    if contradiction < f[cfg.HEADING_ERROR_LIMIT]:
        i[at.HEADING_WRONG_SINCE] = at.NEVER
        return False
    if i[at.HEADING_WRONG_SINCE] == at.NEVER:
        i[at.HEADING_WRONG_SINCE] = time
    return time - i[at.HEADING_WRONG_SINCE] >= i[cfg.HEADING_ERROR_NS]
