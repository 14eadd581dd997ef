"""Alignment in motion: no rest at all, gyro bias unknown, a few seconds between two GNSS epochs.

Over the time T from the first epoch to the second, each compared with the integrals ∫f dt and ∫ω dt at its
own validity, the vehicle accelerates along its course by Δs/T and to the side by s ψ'. What the specific
force has beyond that is gravity: its direction in body axes gives pitch and roll. The mean rate beyond that
of the course is the gyro bias, as pitch and roll come back to where they were. Yaw is the course. All this is
rough; the covariance begins accordingly wide and the filter does the rest.
"""

import math

import numpy as np

from firmware.nav import layout as at
from firmware.nav import tuning as cfg
from firmware.nav.beginning import clear_parameters, enter_navigation, set_velocity_and_position
from firmware.nav.gnss_measurement import epoch_velocity
from firmware.nav.heading import course_and_speed, course_variance, has_course, wrap_pi
from firmware.nav.history import look_up, seconds_between
from firmware.nav.initial_covariance import begin_covariance, correlate_tilt, correlate_yaw
from firmware.nav.strapdown import set_attitude
from firmware.numerics.dialect import kernel
from firmware.numerics.quaternion import quaternion_of_euler
from firmware.numerics.trigonometry import arc_tangent2, sine_cosine

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
THREE = np.int32(3)
LARGEST_TURN = np.float32(0.6)
"""rad; in a sharper turn the mean acceleration in body axes says little."""
# Places behind START_INTEGRALS
SPEED = 6
COURSE = 7
DOWN = 8


@kernel
def align_in_motion(f, i, e, time):
    """Use an epoch, valid at `time`, of a vehicle that was never at rest."""
    if not has_course(e) or not look_up(f, i, time):
        return
    course, speed = course_and_speed(e)
    if not speed > f[cfg.HEADING_SPEED]:
        i[at.START_TIME] = at.NEVER
        return
    turn = wrap_pi(course - f[at.START_INTEGRALS + COURSE])
    if i[at.START_TIME] == at.NEVER or abs(turn) > LARGEST_TURN:
        _start(f, i, e, time, speed, course)
    elif time - i[at.START_TIME] >= i[cfg.MOTION_NS]:
        _finish(f, i, e, time, speed, course, turn)


@kernel
def _start(f, i, e, time, speed, course):
    i[at.START_TIME] = time
    for k in range(THREE):
        f[at.START_INTEGRALS + k] = f[at.AGO_VELOCITY + k]
        f[at.START_INTEGRALS + 3 + k] = f[at.AGO_QUATERNION + 1 + k]
    _, _, down = epoch_velocity(e)
    f[at.START_INTEGRALS + SPEED] = speed
    f[at.START_INTEGRALS + COURSE] = course
    f[at.START_INTEGRALS + DOWN] = down


@kernel
def _finish(f, i, e, time, speed, course, turn):
    per_t = ONE / seconds_between(i[at.START_TIME], time)
    rate = turn * per_t
    _, _, down = epoch_velocity(e)
    along = (speed - f[at.START_INTEGRALS + SPEED]) * per_t
    side = HALF * (speed + f[at.START_INTEGRALS + SPEED]) * rate
    sink = (down - f[at.START_INTEGRALS + DOWN]) * per_t
    s = at.START_INTEGRALS
    a = at.AGO_VELOCITY
    fx = (f[a] - f[s]) * per_t
    fy = (f[a + 1] - f[s + 1]) * per_t
    fz = (f[a + 2] - f[s + 2]) * per_t
    down_force = sink - f[cfg.STANDARD_GRAVITY]
    expected = np.float32(math.sqrt(along * along + side * side + down_force * down_force))
    if abs(np.float32(math.sqrt(fx * fx + fy * fy + fz * fz)) - expected) > f[cfg.MAX_REST_FORCE_ERROR]:
        _start(f, i, e, time, speed, course)  # no sensor that feels gravity
        return
    pitch, roll = _tilt(fx, fy, fz)
    pitch_of_motion, roll_of_motion = _tilt(along, side, sink - f[cfg.STANDARD_GRAVITY])
    pitch -= pitch_of_motion
    roll -= roll_of_motion

    sp, cp = sine_cosine(pitch)
    sr, cr = sine_cosine(roll)
    q = at.AGO_QUATERNION
    clear_parameters(f)
    f[at.GYRO_BIAS] = (f[q + 1] - f[s + 3]) * per_t + rate * sp
    f[at.GYRO_BIAS + 1] = (f[q + 2] - f[s + 4]) * per_t - rate * cp * sr
    f[at.GYRO_BIAS + 2] = (f[q + 3] - f[s + 5]) * per_t - rate * cp * cr
    gyro = f[cfg.MOTION_GYRO_VARIANCE]
    if f[cfg.GYRO_VARIANCE] > ZERO:  # such gyros are better than what a few seconds of motion tell
        gyro = f[cfg.GYRO_VARIANCE]
        for k in range(THREE):
            f[at.GYRO_BIAS + k] = ZERO
    age = seconds_between(time, i[at.TIME])
    yaw = course + (f[at.QUATERNION + 3] - f[q + 3]) - f[at.GYRO_BIAS + 2] * age

    w, x, y, z = quaternion_of_euler(course, pitch, roll)
    f[q] = w
    f[q + 1] = x
    f[q + 2] = y
    f[q + 3] = z
    f[at.AGO_RATE] = -rate * sp
    f[at.AGO_RATE + 1] = rate * cp * sr
    f[at.AGO_RATE + 2] = rate * cp * cr
    w, x, y, z = quaternion_of_euler(yaw, pitch, roll)
    set_attitude(f, w, x, y, z)
    sc, cc = sine_cosine(course)
    centripetal = speed * rate
    set_velocity_and_position(
        f, i, e, time, (along * cc - centripetal * sc) * age, (along * sc + centripetal * cc) * age, ZERO
    )
    yaw_variance = course_variance(f, e, speed) + gyro * age * age
    begin_covariance(f, e, age, f[cfg.MOTION_TILT_VARIANCE], yaw_variance, gyro)
    correlate_tilt(f, w, x, y, z)
    correlate_yaw(f)
    f[at.BIAS_TEMPERATURE] = f[at.TEMPERATURE]
    enter_navigation(f, i)


@kernel
def _tilt(fx, fy, fz):
    """Pitch and roll at which rest would give this direction of the specific force."""
    return arc_tangent2(fx, np.float32(math.sqrt(fy * fy + fz * fz))), arc_tangent2(-fy, -fz)
