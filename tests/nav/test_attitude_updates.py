"""The selectable updates: what each order leaves out, and what coning does to them, in closed form."""

import math

import numpy as np
import pytest
from attitude_rig import DEG, EARTH_RATE, EVERY_PROFILE, PERIOD, Ride, angle_between_deg

from firmware.nav.attitude import layout as at
from firmware.nav.attitude.config import AttitudeConfig
from firmware.nav.attitude.flags import METHOD_NAMES

POLE = 90.0 * DEG
RATE = 290.0 * DEG
EXACT = [method for method in METHOD_NAMES if not method.startswith("rotation_vector")]


def at_pole(rates):
    """Samples whose rates are those relative to n at the north pole for turns about the vertical."""
    rows = np.zeros((len(rates), 9))
    rows[:, 0:3] = rates
    rows[:, 2] -= EARTH_RATE
    rows[:, 5] = -9.8
    return rows


def turned_deg(profile, method, seconds):
    """Yaw after turning at RATE about the vertical."""
    count = 2 * round(seconds / PERIOD) + 1
    rates = np.tile([0.0, 0.0, RATE], (count, 1))
    config = AttitudeConfig(latitude=POLE, attitude=(0.0, 0.0, 0.0), method=method)
    return Ride(profile, config).drive(at_pole(rates), every=10**9).angles_deg[0]


@pytest.mark.parametrize("profile", EVERY_PROFILE)
@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_error_of_each_order_in_a_plain_turn(profile, order):
    """An iteration turns by 2 atan(v θ / s), with s and v the truncated series of (2-33) … (2-36)."""
    theta = RATE * PERIOD
    scalar = [1.0, 1.0 - theta**2 / 8, 1.0 - theta**2 / 8, 1.0 - theta**2 / 8 + theta**4 / 384][order - 1]
    vector = [0.5, 0.5, 0.5 - theta**2 / 48, 0.5 - theta**2 / 48][order - 1]
    iterations = round(10.0 / PERIOD)
    expected = math.degrees(iterations * 2.0 * math.atan2(vector * theta, scalar))
    found = turned_deg(profile, f"rotation_vector_{order}", 10.0)
    bound = {"float32": 6e-3, "fixed": 1e-4, "float64": 5e-6}[profile]
    assert (found - expected + 180.0) % 360.0 - 180.0 == pytest.approx(0.0, abs=bound)


@pytest.mark.parametrize("profile", EVERY_PROFILE)
@pytest.mark.parametrize("method", EXACT)
def test_the_other_updates_turn_by_what_was_turned(profile, method):
    """Runge and Kutta leave out (λT)⁵/120: of half the angle in a quaternion, of the whole in a matrix."""
    found = turned_deg(profile, method, 10.0)
    share = {"rk4": 1.0 / 1920.0, "direction_cosines": 1.0 / 120.0}.get(method, 0.0)
    left_out = math.degrees(round(10.0 / PERIOD) * (RATE * PERIOD) ** 5 * share)
    bound = {"float32": 0.03, "fixed": 1e-3, "float64": 3e-6}[profile]
    error = (found - math.degrees(RATE * 10.0) + 180.0) % 360.0 - 180.0
    assert error == pytest.approx(-left_out, abs=bound)


def coning(seconds, half_angle, frequency):
    """Rates of a body whose z axis goes round a cone without turning about it, and q_nb of the end."""
    count = 2 * round(seconds / PERIOD) + 1
    t = 0.5 * PERIOD * np.arange(count)
    w = 2.0 * math.pi * frequency
    rates = np.column_stack(
        (
            -w * math.sin(half_angle) * np.sin(w * t),
            w * math.sin(half_angle) * np.cos(w * t),
            np.full(count, w * (math.cos(half_angle) - 1.0)),
        )
    )
    # q = cos(a/2) + sin(a/2) (cos wt, sin wt, 0): ω = 2 q* ⊗ q̇ has w (cos a − 1) along z
    half = 0.5 * half_angle
    end = np.array(
        [math.cos(half), math.sin(half) * math.cos(w * t[-1]), math.sin(half) * math.sin(w * t[-1]), 0]
    )
    return rates, end


@pytest.mark.parametrize("profile", EVERY_PROFILE)
@pytest.mark.parametrize("method", METHOD_NAMES)
def test_coning(profile, method):
    """10 Hz, 1° half angle, 20 s. A sum of angles misses ½ Ω sin²a (1 − sin ΩT / ΩT) a second."""
    seconds, half_angle, frequency = 20.0, 1.0 * DEG, 10.0
    rates, end = coning(seconds, half_angle, frequency)
    config = AttitudeConfig(latitude=POLE, attitude=(0.0, 0.0, 0.0), method=method)
    ride = Ride(profile, config)
    ride.s[at.QUATERNION : at.QUATERNION + 4] = np.array(
        [math.cos(half_angle / 2), math.sin(half_angle / 2), 0.0, 0.0]
    ) * (2.0**30 if profile == "fixed" else 1.0)
    ride.drive(at_pole(rates), every=10**9)
    drift = angle_between_deg(ride.quaternion(), end)[0]
    w = 2.0 * math.pi * frequency
    missed = 0.5 * w * math.sin(half_angle) ** 2 * (1.0 - math.sin(w * PERIOD) / (w * PERIOD)) * seconds
    if method.startswith("rotation_vector"):
        assert drift == pytest.approx(math.degrees(missed), rel=0.01)
    else:
        assert drift < 0.02 * math.degrees(missed)
