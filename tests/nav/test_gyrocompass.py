"""Yaw without the second antenna, and a baseline that lies anyhow in the body of a tilted vehicle."""

import math

import numpy as np
import pytest
from nav_drive import within_pi
from nav_run import dcm
from tactical_drive import ANTENNA, BASELINE, Drive, Errors, changed, make_drive
from tactical_run import run
from test_reference_faults import without_heading

from firmware.drivers import gnss_epoch as gnss
from firmware.nav import layout as at
from firmware.nav import reference_report as told
from firmware.nav.flags import NAVIGATING, WAITING_FOR_HEADING
from firmware.nav.full_combination import full_combination
from firmware.nav.reference_config import AttitudeReference

E = Errors()
EARTH_RATE, LATITUDE = 7.292115e-5, math.radians(30.5278)
"""Of the scenario `static`."""


def closed_form_sigma(seconds: float) -> float:
    """Of a gyro-compass with these gyros: bias, white noise, the tilt seen by the accelerometers."""
    instability = math.radians(0.01) / 3600.0
    tilt = 2.0 * (E.velocity_walk / 9.80665 / seconds) ** 2
    rate = E.gyro_bias**2 + instability**2 + E.angle_walk**2 / seconds + tilt
    level = (E.accel_bias / 9.80665 * math.tan(LATITUDE)) ** 2
    return math.sqrt(rate / (EARTH_RATE * math.cos(LATITUDE)) ** 2 + level)


def waiting(seed: int, duration_s: float) -> Drive:
    return changed(make_drive(seed, "static", duration_s), 0.0, 1e9, without_heading)


def compassing(**choices: float) -> object:
    reference = AttitudeReference(baseline=BASELINE, **choices)  # type: ignore[arg-type]
    return full_combination(BASELINE, antenna_lever_arm=ANTENNA, attitude=reference)


def test_sigma_told_against_time_and_the_errors_it_stands_for() -> None:
    """Ten starts: at 20, 50 and 90 s the error is of the size that is told, and that is the closed form."""
    squares = []
    for seed in range(30, 40):
        drive = waiting(seed, 100.0)
        one = run(drive, compassing(), "float32")
        assert np.all(one.mode[one.t > 15.0] == WAITING_FOR_HEADING)
        for second in (20, 50, 90):
            report = one.reports[second - 1]
            sigma = float(report[told.COMPASS_SIGMA])
            assert sigma == pytest.approx(closed_form_sigma(float(report[told.COMPASS_TIME])), rel=0.02)
            error = within_pi(float(report[told.COMPASS_HEADING]) - drive.truth.yaw[second - 1])
            squares.append((error / sigma) ** 2)
    assert 0.4 < np.mean(squares) < 1.9


def test_five_minutes_reach_half_a_degree_and_navigate() -> None:
    """In one run to the end: 302 s, then navigation with yaw tied to the east gyro bias."""
    drive = waiting(41, 330.0)
    one = run(drive, compassing(), "float32")
    begun = one.t[one.mode == NAVIGATING][0]
    assert 300.0 < begun < 304.0
    assert one.counts[-1, told.YAW_SOURCE] == 4
    sigma = one.sigma[-1, 8]
    assert math.degrees(sigma) == pytest.approx(math.degrees(closed_form_sigma(300.0)), rel=0.05)
    assert abs(one.attitude[-1, 2]) < 4.0 * sigma
    u = one.f[at.U : at.D].reshape(at.STATES, at.STATES).T.astype(float)
    whole = np.triu(u, 1) + np.eye(at.STATES)
    p = whole @ np.diag(one.f[at.D : at.D + at.STATES].astype(float)) @ whole.T
    east = one.f[at.C_N_B + 3 : at.C_N_B + 6]
    yaw = at.X_ATTITUDE + 2
    tied = p[yaw, at.X_GYRO_BIAS : at.X_GYRO_BIAS + 3] @ east
    assert tied == pytest.approx(E.gyro_bias**2 / (EARTH_RATE * math.cos(LATITUDE)), rel=0.15)


def test_the_second_antenna_comes_later() -> None:
    """Yaw of the gyros first, then of the baseline: taken at once, well within the gate."""
    drive = changed(make_drive(42, "static", 110.0), 0.0, 80.0, without_heading)
    one = run(drive, compassing(compass_time=60.0), "float32")
    before, after = one.sigma[one.t == 79.0, 8][0], one.sigma[one.t == 90.0, 8][0]
    assert math.degrees(before) > 0.5 > 0.15 > math.degrees(after)
    assert abs(one.attitude[-1, 2]) < 4.0 * after
    assert one.counts[-1, told.REFUSED] == 0


def test_no_compass_without_knowledge_of_the_gyros() -> None:
    config = full_combination(BASELINE, gyro_bias_sigma=0.0)
    one = run(waiting(43, 90.0), config, "float32")
    assert one.reports[-1, told.COMPASS_SIGMA] == pytest.approx(math.pi)


@pytest.mark.parametrize("baseline", [(1.2, -0.8, 0.3), (0.0, 1.5, 0.0)])
def test_baseline_anyhow_in_a_tilted_vehicle(baseline: tuple[float, float, float]) -> None:
    """Heading and pitch of the vector by its own geometry give yaw of the body; no innovation is left."""
    tilted = ("initial.yaw_deg=75", "initial.pitch_deg=8", "initial.roll_deg=-5")
    drive = make_drive(44, "static", 90.0, overrides=tilted)
    vector = dcm(drive.truth.yaw[0], drive.truth.pitch[0], drive.truth.roll[0]) @ np.array(baseline)
    heading = math.degrees(math.atan2(vector[1], vector[0])) % 360.0
    pitch = math.degrees(-math.asin(vector[2] / np.linalg.norm(vector)))
    for e, error in zip(drive.epochs, drive.heading_error, strict=True):
        e[gnss.FLAGS] |= gnss.HAS_PITCH
        e[gnss.HEADING_E5DEG] = round((heading + math.degrees(error)) % 360.0 * 1e5)
        e[gnss.PITCH_E5DEG] = round(pitch * 1e5)
        e[gnss.BASELINE_MM] = round(np.linalg.norm(baseline) * 1e3)
    one = run(drive, full_combination(baseline, antenna_lever_arm=ANTENNA), "float32")
    assert one.mode[-1] == NAVIGATING
    assert abs(math.degrees(one.attitude[-1, 2])) < 0.3
    assert np.all(np.abs(np.degrees(one.attitude[-1, :2])) < 0.05)
    assert one.counts[-1, told.MASK] == 3
    assert abs(math.degrees(one.reports[-1, told.INNOVATION + 1])) < 0.05
