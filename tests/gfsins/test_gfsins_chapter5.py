"""Chapter 5 of the document on the board: its compass, and a beginning that an operator enters."""

import numpy as np
import pytest

from firmware.apps.gfsins.entered import certainty, entered_beginning
from firmware.apps.gfsins.settings import Settings
from firmware.nav.gyro_free.filters import Beginning
from host.sim.compass import WrongAngles
from host.sim.errors.ambient_schema import CompassErrors
from host.sim.truth import TruthBatch, unknown_bias

FOUND = Beginning(10_000_000_000, 28_201_000_000, 112_927_000_000, 7.0, (10.0, 0.0, 0.0), (0.5, 0.01, 0.02))
ENTERED = {
    "begin_latitude_deg": 28.2,
    "begin_longitude_deg": 112.927,
    "begin_height_m": 5.0,
    "begin_north_mps": 11.0,
    "begin_east_mps": 0.5,
    "begin_down_mps": -0.1,
    "begin_heading_deg": 90.0,
    "begin_pitch_deg": 1.0,
    "begin_roll_deg": -2.0,
}


def level(count: int, step_ns: int) -> TruthBatch:
    zeros = np.zeros(count)
    times = np.arange(1, count + 1, dtype=np.int64) * step_ns
    bias = unknown_bias(count)
    return TruthBatch(times, zeros, zeros, zeros, np.zeros((count, 3)), zeros, zeros, zeros, bias, bias)


def test_what_is_entered_goes_on_by_its_velocity_until_navigation_begins() -> None:
    begun = entered_beginning(FOUND, ENTERED)
    assert begun is not None
    # 110 m north at 28.2 degrees: a minute of latitude is 1847.2 m there
    assert begun.latitude_nanodeg * 1e-9 == pytest.approx(28.2 + 110.0 / 1847.2 / 60.0, abs=2e-7)
    # a minute of longitude is 1637.0 m
    assert begun.longitude_nanodeg * 1e-9 == pytest.approx(112.927 + 5.0 / 1637.0 / 60.0, abs=2e-7)
    assert begun.height == pytest.approx(6.0)
    assert begun.velocity == (11.0, 0.5, -0.1)
    assert begun.angles == pytest.approx((np.pi / 2, np.pi / 180, -np.pi / 90))
    assert set(certainty(ENTERED)) == {"sigma_position", "sigma_velocity", "sigma_tilt", "sigma_yaw"}


def test_a_place_where_the_receiver_is_not_is_refused() -> None:
    assert entered_beginning(FOUND, ENTERED | {"begin_latitude_deg": 28.203}) is None
    only_angles = {key: ENTERED[key] for key in ("begin_heading_deg", "begin_pitch_deg", "begin_roll_deg")}
    begun = entered_beginning(FOUND, only_angles)
    assert begun is not None
    assert begun.latitude_nanodeg == FOUND.latitude_nanodeg
    assert begun.velocity == FOUND.velocity


def test_half_a_place_is_no_place() -> None:
    with pytest.raises(ValueError, match=r"begin_longitude_deg is missing beside begin_latitude_deg = 28.2"):
        Settings.of({"begin_latitude_deg": 28.2})
    with pytest.raises(ValueError, match=r"begin_pitch_deg = 95.0 is no number from -89 to 89"):
        Settings.of({"begin_pitch_deg": 95.0})


def test_a_compass_shows_the_errors_of_its_scenario() -> None:
    errors = CompassErrors(
        noise_deg=[0.5, 0.5, 1.0], markov_deg=[0.03, 0.04, 0.1], initial_deg=[2.0, 0.0, 0.0]
    )
    shown = WrongAngles(errors, 1, "compass").shown(level(20_000, 100_000_000))
    angles = np.degrees(np.column_stack((shown.pitch, shown.roll, shown.yaw)))
    assert np.std(np.diff(angles, axis=0), axis=0) / np.sqrt(2) == pytest.approx([0.5, 0.5, 1.0], rel=0.03)
    # what it begins with is gone after seven times its correlation time
    assert abs(np.mean(angles[-3000:, 0])) < 0.15
    quiet = WrongAngles(CompassErrors(initial_deg=1.0, markov_time_s=100.0), 1, "compass")
    yaw = quiet.shown(level(3, 50_000_000_000)).yaw
    assert yaw[1:] / yaw[:-1] == pytest.approx([np.exp(-0.5)] * 2)
