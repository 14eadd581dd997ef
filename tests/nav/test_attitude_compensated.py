"""The loop with the drift compensation behind it: fixed point against float64."""

import numpy as np
import pytest
from attitude_rig import (
    DEG,
    FLIGHT_BEGIN,
    HEIGHT,
    LATITUDE,
    LONGITUDE,
    Ride,
    angle_between_deg,
    bursts,
    flight,
    flight_field,
)

from firmware.nav.attitude import layout as at
from firmware.nav.attitude.config import AttitudeConfig
from firmware.nav.drift.fixed.correction import correct as correct_fixed
from firmware.nav.drift.fixed.settings import new_state as new_fixed_state
from firmware.nav.drift.settings import DriftSettings, new_state
from firmware.numerics.precision import load

SECONDS = 600.0


def compensated(profile, words):
    """Quaternions once a second."""
    config = AttitudeConfig(
        latitude=LATITUDE, longitude=LONGITUDE, height=HEIGHT, attitude=FLIGHT_BEGIN, declination=0.05
    )
    ride = Ride(profile, config)
    settings = DriftSettings(rate_range=300.0 * DEG, declination=0.05)
    if profile == "fixed":
        correct, (d, k) = correct_fixed, new_fixed_state(config.period, settings)
    else:
        correct = load("firmware.nav.drift.correction", profile).correct
        d, k = new_state(settings, np.dtype(profile))
    found = []
    for row in words:
        ride.loop.take_words(ride.s, ride.i, row)
        if ride.loop.iterate(ride.s, ride.i):
            correct(ride.s, ride.i, d, k)
            if ride.i[at.ITERATIONS] % 125 == 0:
                found.append(ride.quaternion())
    return np.array(found)


@pytest.mark.parametrize("bias", [pytest.param((0.0, 0.0, 0.0), marks=pytest.mark.soak), (0.3, -0.2, 0.1)])
def test_ten_minutes_of_compensated_flight_as_in_float64(bias):
    """Wanted is 0.01° RMS. Both learn bias and heading from the same words, each in its own numbers."""
    samples = flight(SECONDS, noise=True)
    samples[:, 0:3] += np.array(bias) * DEG
    samples[:, 6:9] = flight_field(SECONDS)
    words = bursts(samples)
    apart = angle_between_deg(compensated("fixed", words), compensated("float64", words))
    assert len(apart) == SECONDS
    assert np.sqrt(np.mean(apart**2)) < 0.002
