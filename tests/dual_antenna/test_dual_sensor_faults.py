"""The inertial unit lies with good frames, the pulse fails, a clock is off: told, and over again."""

from __future__ import annotations

import pytest
from board_run import Driven, fault
from dual_runs import UNIT, drive


@pytest.fixture(scope="module")
def lied_to() -> Driven:
    """A unit that freezes on the road; a clock that is off and a pulse that fails; a gyro that runs away."""
    faults = (
        fault("sensor-frozen", UNIT, 30.0, 5.0),
        fault("sensor-frozen", UNIT, 90.0, 10.0),
        fault("chip-clock", UNIT, 130.0, 5.0, ppm=5000.0),
        fault("pin-stuck", "GNSS_PPS", 150.0, 10.0),
        '{ kind = "sensor-drift", target = "U3", at_s = 180.0, duration_s = 10.0,'
        ' parameters = { quantity = "gyro", rate = 0.01 } }',
    )
    return drive("road", "duration_s=240", f"fault=[{', '.join(faults)}]")


def test_a_frozen_unit_is_told_and_not_integrated(lied_to: Driven) -> None:
    """Its rounding toggles by one unit, so that no two samples need be equal."""
    assert 90.4 < lied_to.said("IMU frozen", 50.0) < 91.0
    assert lied_to.worst("error_north_m", 90.0, 101.0) < 10.0
    assert lied_to.worst("error_east_m", 90.0, 101.0) < 10.0
    assert lied_to.worst("error_roll_deg", 110.0, 125.0) < 0.2
    assert lied_to.worst("error_yaw_deg", 110.0, 125.0) < 0.2


def test_a_unit_that_freezes_at_rest_is_told(lied_to: Driven) -> None:
    """Its noise is two hundred units: not even at rest are two samples alike."""
    assert 30.4 < lied_to.said("IMU frozen") < 31.0
    assert lied_to.worst("error_north_m", 30.0, 60.0) < 8.0
    assert lied_to.worst("error_v_down_mps", 55.0, 89.0) < 0.3


def test_a_clock_that_is_off_is_told(lied_to: Driven) -> None:
    assert 132.0 < lied_to.said("IMU clock +5") < 135.0
    assert 136.0 < lied_to.said("IMU clock is good again") < 141.0


def test_a_pulse_that_fails_is_told(lied_to: Driven) -> None:
    assert 152.0 < lied_to.said("time pulse lost") < 156.0
    assert 160.0 < lied_to.said("time pulse is back") < 165.0


def test_gyros_that_run_away_are_outvoted(lied_to: Driven) -> None:
    assert 180.0 < lied_to.said("second antenna: angles refused", 180.0) < 184.0
    again = lied_to.said("heading contradicted by the course, aligning again", 185.0)
    assert again < 205.0
    assert lied_to.worst("error_yaw_deg", 225.0, 240.0) < 0.5
    assert lied_to.worst("error_roll_deg", 225.0, 240.0) < 0.5
    assert lied_to.worst("error_north_m", 225.0, 240.0) < 8.0
