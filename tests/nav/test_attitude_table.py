"""The rotary table of the document's tables at the kernel's door, with exact rates, row by row.

The table turns at 20 °/s from level, speeding up and slowing down at 100 °/s², and holds 5 s.
"""

import numpy as np
import pytest
from attitude_rig import DEG, EARTH_RATE, PERIOD, Ride, angle_between_deg

from firmware.nav.attitude.config import AttitudeConfig, quaternion

SPEED, ACCELERATION, HOLD_S = 20.0 * DEG, 100.0 * DEG, 5.0
PLACE = 39.0 * DEG
YAW, PITCH, ROLL = range(3)
ROWS = [
    *((PITCH, angle) for angle in range(-90, 100, 10)),
    *((ROLL, angle) for angle in range(-180, 190, 10)),
    *((YAW, angle) for angle in range(0, 370, 10)),
]
BOUND_DEG = 0.05


def turn(angle):
    """Angle and rate of the table at the times of the samples, and how many of them are the hold."""
    size = abs(angle)
    ramp = min(SPEED / ACCELERATION, np.sqrt(size / ACCELERATION))
    top = ACCELERATION * ramp
    even = size / top - ramp if size else 0.0
    held = round(HOLD_S / PERIOD)
    count = 2 * (held + int((2.0 * ramp + even) / PERIOD) + 1) + 1
    t = 0.5 * PERIOD * np.arange(count)
    rates = np.clip(np.minimum(ACCELERATION * t, top - ACCELERATION * (t - ramp - even)), 0.0, top)
    up, down = np.clip(t, 0.0, ramp), np.clip(t - ramp - even, 0.0, ramp)
    angles = 0.5 * ACCELERATION * up**2 + top * np.clip(t - ramp, 0.0, even) + top * down
    angles -= 0.5 * ACCELERATION * down**2
    return np.sign(angle) * angles, np.sign(angle) * rates, held


def samples_of(axis, angles, rates):
    """ω, f and m of a turn about the body axis that stands for yaw, pitch or roll."""
    e = np.eye(3)[2 - axis]
    rows = np.zeros((len(angles), 9))
    earth = EARTH_RATE * np.array([np.cos(PLACE), 0.0, -np.sin(PLACE)])
    rows[:, 0:3] = turned_back(earth, e, angles) + rates[:, None] * e
    rows[:, 3:6] = turned_back(np.array([0.0, 0.0, -9.80]), e, angles)
    return rows


def turned_back(v, e, angles):
    """A vector in axes that turned about the unit vector e (Rodrigues)."""
    c, s = np.cos(angles)[:, None], np.sin(angles)[:, None]
    return c * v - s * np.cross(e, v) + (1.0 - c) * (e @ v) * e


def worst_error_deg(profile, axis, angle_deg):
    """In the hold: by angles, wrapped; by total rotation where pitch is 80° and more."""
    angles, rates, held = turn(angle_deg * DEG)
    ride = Ride(profile, AttitudeConfig(latitude=PLACE, attitude=(0.0, 0.0, 0.0)))
    ride.drive(samples_of(axis, angles, rates), every=25)
    last = -(held // 25)
    wanted = [angle_deg * DEG if k == axis else 0.0 for k in range(3)]
    if axis == PITCH and abs(angle_deg) >= 80:
        return angle_between_deg(np.array(ride.quaternions[last:]), np.array(quaternion(wanted))).max()
    found = np.array(ride.records)[last:, :3] * 1e-9
    return np.degrees(np.abs((found - wanted + np.pi) % (2.0 * np.pi) - np.pi)).max()


@pytest.mark.parametrize("profile", ["float32", "fixed"])
@pytest.mark.parametrize("axis", [PITCH, ROLL, YAW])
def test_every_row_of_the_table(profile, axis):
    worst = {angle: worst_error_deg(profile, axis, angle) for on, angle in ROWS if on == axis}
    assert max(worst.values()) < BOUND_DEG, worst


def test_turn_of_the_table_ends_where_it_should():
    for angle in (0.0, 0.001, 0.02, -1.0, 2.0 * np.pi):
        angles, rates, held = turn(angle)
        assert angles[-2 * held :] == pytest.approx(angle)
        assert np.trapezoid(rates, dx=0.5 * PERIOD) == pytest.approx(angle, abs=1e-5)
