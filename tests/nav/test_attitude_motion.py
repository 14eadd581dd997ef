"""Attitude, velocity and position of a flight against an integration in the Earth frame."""

import functools
import math

import numpy as np
import pytest
from attitude_rig import (
    EARTH_RATE,
    EVERY_PROFILE,
    FLIGHT_BEGIN,
    HEIGHT,
    LATITUDE,
    LONGITUDE,
    PERIOD,
    Ride,
    angle_between_deg,
    at_rest,
    earth_frame_oracle,
    flight,
    rotation,
)

from firmware.nav.attitude import layout as at
from firmware.nav.attitude.config import AttitudeConfig, quaternion

VELOCITY = (25.0, 10.0, -1.0)
SECONDS = 120.0


@functools.cache
def truth():
    """Latitude, longitude, height, velocity NED and q_nb at the end."""
    oracle = earth_frame_oracle()
    samples = flight(SECONDS)
    C_e_n = oracle.rotation_ned_to_ecef(LATITUDE, LONGITUDE)
    radius = oracle.A / math.sqrt(1.0 - oracle.E2 * math.sin(LATITUDE) ** 2)
    place = np.array(
        [
            (radius + HEIGHT) * math.cos(LATITUDE) * math.cos(LONGITUDE),
            (radius + HEIGHT) * math.cos(LATITUDE) * math.sin(LONGITUDE),
            (radius * (1.0 - oracle.E2) + HEIGHT) * math.sin(LATITUDE),
        ]
    )
    q_eb = quaternion_of_matrix(C_e_n @ rotation(*FLIGHT_BEGIN))
    state = np.concatenate((place, C_e_n @ np.array(VELOCITY), q_eb))
    end = oracle.integrate(state, samples[:, 3:6].copy(), samples[:, 0:3].copy(), PERIOD)
    latitude, longitude, height = oracle.geodetic(*end[:3])
    C_n_e = oracle.rotation_ned_to_ecef(latitude, longitude).T
    q_nb = quaternion_of_matrix(C_n_e @ matrix_of_quaternion(end[6:]))
    return latitude, longitude, height, C_n_e @ end[3:6], q_nb


def matrix_of_quaternion(q):
    w, v = q[0], q[1:]
    skew = np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
    return np.eye(3) + 2.0 * w * skew + 2.0 * skew @ skew


def quaternion_of_matrix(C):
    """By the eigenvector of Bar-Itzhack's matrix: works for every rotation."""
    K = np.array(
        [
            [C[0, 0] + C[1, 1] + C[2, 2], C[2, 1] - C[1, 2], C[0, 2] - C[2, 0], C[1, 0] - C[0, 1]],
            [C[2, 1] - C[1, 2], C[0, 0] - C[1, 1] - C[2, 2], C[0, 1] + C[1, 0], C[0, 2] + C[2, 0]],
            [C[0, 2] - C[2, 0], C[0, 1] + C[1, 0], C[1, 1] - C[0, 0] - C[2, 2], C[1, 2] + C[2, 1]],
            [C[1, 0] - C[0, 1], C[0, 2] + C[2, 0], C[1, 2] + C[2, 1], C[2, 2] - C[0, 0] - C[1, 1]],
        ]
    )
    return np.linalg.eigh(K)[1][:, -1]


@pytest.mark.parametrize(
    ("profile", "attitude_deg", "velocity_mps", "position_m"),
    [("float64", 5e-6, 5e-5, 3e-3), ("fixed", 1e-5, 3e-4, 0.02), ("float32", 1.5e-3, 5e-3, 0.3)],
)
def test_flight_as_in_the_earth_frame(profile, attitude_deg, velocity_mps, position_m):
    """Two minutes with turns; the other side integrates by Runge and Kutta, Earth-fixed and in float64."""
    config = AttitudeConfig(
        latitude=LATITUDE, longitude=LONGITUDE, height=HEIGHT, attitude=FLIGHT_BEGIN, velocity=VELOCITY
    )
    ride = Ride(profile, config).drive(flight(SECONDS))
    record = ride.record()
    latitude, longitude, height, velocity, q_nb = truth()
    north = (math.radians(record[at.OUT_LATITUDE] * 1e-9) - latitude) * 6.38e6
    east = (math.radians(record[at.OUT_LONGITUDE] * 1e-9) - longitude) * 6.40e6 * math.cos(latitude)
    up = record[at.OUT_HEIGHT] * 1e-6 - height
    print(
        profile,
        angle_between_deg(ride.quaternion(), q_nb),
        record[6:9] * 1e-6 - velocity,
        velocity,
        north,
        east,
        up,
    )
    assert angle_between_deg(ride.quaternion(), q_nb) < attitude_deg
    assert record[at.OUT_VELOCITY : at.OUT_VELOCITY + 3] * 1e-6 == pytest.approx(velocity, abs=velocity_mps)
    assert (north, east, up) == pytest.approx((0.0, 0.0, 0.0), abs=position_m)
    assert not ride.i[at.SATURATIONS : at.SATURATIONS + 8].any()


@pytest.mark.parametrize("profile", EVERY_PROFILE)
def test_standing_still_stays(profile):
    """Earth rate and gravity alone: after a minute on a slope nothing has moved."""
    angles = (1.0, 0.1, -0.2)
    config = AttitudeConfig(latitude=LATITUDE, longitude=LONGITUDE, height=HEIGHT, attitude=angles)
    samples = at_rest(angles, 15_001)
    ride = Ride(profile, config).drive(samples)
    assert angle_between_deg(ride.quaternion(), np.array(quaternion(angles))) < 1e-3
    velocity = ride.record()[at.OUT_VELOCITY : at.OUT_VELOCITY + 2] * 1e-6
    assert velocity == pytest.approx((0.0, 0.0), abs=0.005)


@pytest.mark.parametrize("profile", ["fixed", "float64"])
def test_less_than_a_unit_an_iteration_still_moves(profile):
    """0.1 mm/s is 0.14 units of latitude and 0.84 of height an iteration: nothing of it is lost.

    (A float32 of gravity is wrong by as much after 100 s.)
    """
    speed = 1.0e-4
    config = AttitudeConfig(attitude=(0.0, 0.0, 0.0), velocity=(speed, 0.0, -speed))
    ride = Ride(profile, config)
    from_equator = np.zeros((25_001, 9))
    from_equator[:, 0] = EARTH_RATE
    gravity = 9.7803253359
    from_equator[:, 5] = -gravity
    ride.drive(from_equator)
    north = math.radians(ride.i[at.LATITUDE] * math.degrees(2.0**-40)) * 6_335_439.0
    assert north == pytest.approx(100.0 * speed, rel=0.25)
    assert ride.i[at.HEIGHT] * 2.0**-20 == pytest.approx(100.0 * speed, rel=0.25)
