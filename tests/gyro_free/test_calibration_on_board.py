"""On-board least squares against numpy, and calibrations against the errors that were put in."""

import math

import numpy as np
import pytest

from firmware.nav.gyro_free import compass_calibration as compass
from firmware.nav.gyro_free import least_squares as ls
from firmware.nav.gyro_free import table_calibration as table
from firmware.nav.gyro_free.twelve_positions import DOCUMENT, felt_at, position_axes

G, EARTH, LATITUDE = 9.7915, 7.292115e-5, math.radians(28.2)


def deviation(angle: float, coefficients: tuple[float, ...]) -> float:
    a, b, c, d, e = coefficients
    s, k = math.sin(angle), math.cos(angle)
    return a + b * s + c * k + d * math.sin(2 * angle) + e * math.cos(2 * angle)


def shown(true: float, coefficients: tuple[float, ...]) -> float:
    """Fixed point of shown = true + Δβ(shown)."""
    angle = true
    for _ in range(60):
        angle = true + deviation(angle, coefficients)
    return angle % (2.0 * math.pi)


def test_deviation_is_numpys_least_squares_with_its_covariance() -> None:
    rng = np.random.default_rng(1)
    true = np.radians(np.arange(0.0, 360.0, 15.0))
    wanted = (0.02, -0.08, 0.05, 0.03, -0.015)
    angles = np.array([shown(one, wanted) for one in true]) + rng.normal(0.0, 0.005, 24)
    q = np.zeros(ls.SIZE, np.float32)
    compass.begin_calibration(q)
    for angle, one in zip(angles, true, strict=True):
        compass.take_heading(q, float(angle), float(one))
    assert compass.solve_deviation(q)
    rows = np.column_stack(
        (np.ones(24), np.sin(angles), np.cos(angles), np.sin(2 * angles), np.cos(2 * angles))
    )
    difference = (angles - true + math.pi) % (2 * math.pi) - math.pi
    expected, squares, _, _ = np.linalg.lstsq(rows, difference, rcond=None)
    covariance = np.linalg.inv(rows.T @ rows) * squares[0] / 19
    assert q[ls.X : ls.X + 5] == pytest.approx(expected, abs=2e-6)
    assert q[ls.SIGMA : ls.SIGMA + 5] == pytest.approx(np.sqrt(np.diag(covariance)), rel=1e-3)
    assert np.all(np.abs(expected - wanted) < 4 * q[ls.SIGMA : ls.SIGMA + 5])


@pytest.mark.parametrize("count", [0, 4, 24])
def test_headings_that_do_not_tell_are_refused(count: int) -> None:
    q = np.zeros(ls.SIZE, np.float32)
    for _ in range(count):
        compass.take_heading(q, 1.0, 1.1)
    assert not compass.solve_deviation(q)


def test_ellipse_is_turned_back_into_the_circle() -> None:
    rng = np.random.default_rng(2)
    soft = np.array(((1.1, 0.15), (0.15, 0.85)))
    soft /= math.sqrt(np.linalg.det(soft))
    hard = np.array((0.4, -0.25))
    angles = rng.uniform(0.0, 2 * math.pi, 60)
    fields = 0.6 * np.column_stack((np.cos(angles), np.sin(angles))) @ soft.T + hard
    q, result = np.zeros(ls.SIZE, np.float32), np.zeros(compass.ELLIPSE_SIZE, np.float32)
    compass.begin_calibration(q)
    for x, y in (fields + rng.normal(0.0, 1e-4, fields.shape)).tolist():
        compass.take_field(q, x, y)
    assert compass.solve_ellipse(q, result)
    assert result[3:5] == pytest.approx(hard, abs=5e-4)
    found = np.array(((result[0], result[1]), (result[1], result[2])))
    assert found == pytest.approx(np.linalg.inv(soft), abs=1e-3)
    radii = np.linalg.norm((fields - result[3:5]) @ found.T, axis=1)
    assert np.ptp(radii) < 2e-3


def test_a_line_is_no_ellipse() -> None:
    q, result = np.zeros(ls.SIZE, np.float32), np.zeros(compass.ELLIPSE_SIZE, np.float32)
    for x in np.linspace(-1.0, 1.0, 20):
        compass.take_field(q, float(x), float(x) * x)
    assert not compass.solve_ellipse(q, result)


RESPONSE = np.array(((1.01, 0.004, -0.003), (-0.002, 0.985, 0.006), (0.005, -0.004, 1.02)))
OFFSET = np.array((0.3, -0.25, 0.35))


def calibrated(references: np.ndarray, noise: float, seed: int) -> tuple[bool, np.ndarray]:
    rng = np.random.default_rng(seed)
    axes = [np.zeros(ls.SIZE, np.float32) for _ in range(3)]
    for reference in references:
        read = RESPONSE @ reference + OFFSET + rng.normal(0.0, noise, 3)
        for axis in range(3):
            table.take_position(axes[axis], *reference.tolist(), float(read[axis]))
    result = np.zeros(table.RESULT_SIZE, np.float32)
    return table.solve_positions(*axes, result), result


def test_twelve_positions_give_accelerometers_and_say_that_rates_are_not_to_be_had() -> None:
    felt = np.array([felt_at(names, LATITUDE, G, EARTH) for names in DOCUMENT])
    good, force = calibrated(felt[:, :3], 2e-4, 3)
    assert good
    assert force[table.RESPONSE : table.RESPONSE + 9] == pytest.approx(RESPONSE.ravel(), abs=1e-4)
    assert force[table.OFFSET : table.OFFSET + 3] == pytest.approx(OFFSET, abs=5e-4)
    matrix = force[:9].reshape(3, 3).astype(float)
    assert matrix @ (RESPONSE @ felt[4, :3] + OFFSET) - force[9:12] == pytest.approx(felt[4, :3], abs=1e-3)
    # one position for a minute: 0.65°/s per √s of rate random walk leaves far more than 15°/h
    good, rate = calibrated(felt[:, 3:], 0.01, 4)
    if good:
        assert np.all(rate[table.SIGMA_RESPONSE : table.SIGMA_RESPONSE + 9] > 10.0)


def test_the_documents_formulas_hold_for_the_corrected_directions() -> None:
    """(3.11) and (3.12), gravity counted as the document does (down positive)."""
    felt = np.array([felt_at(names, LATITUDE, G, EARTH) for names in DOCUMENT])
    read = -(felt[:, :3] @ RESPONSE.T) + OFFSET
    a = {number: read[number - 1] for number in range(1, 13)}
    assert (a[5][0] - a[7][0]) / (2 * G) == pytest.approx(RESPONSE[0, 0])
    assert (a[12][1] - a[10][1]) / (2 * G) == pytest.approx(RESPONSE[1, 1])
    assert (a[12][0] - a[10][0]) / (2 * G) == pytest.approx(RESPONSE[0, 1])
    assert (a[5][2] - a[7][2]) / (2 * G) == pytest.approx(RESPONSE[2, 0])


def test_turns_of_a_rate_table_give_the_rates() -> None:
    turns = [sign * rate * axis for axis in np.eye(3) for rate in (0.5, 1.0, 2.0) for sign in (1.0, -1.0)]
    good, result = calibrated(np.array(turns), 0.003, 5)
    assert good
    wanted = np.concatenate((RESPONSE.ravel(), OFFSET))
    sigmas = result[table.SIGMA_RESPONSE : table.SIGMA_OFFSET + 3]
    assert np.all(sigmas < 0.003)
    found = result[table.RESPONSE : table.OFFSET + 3]
    assert np.all(np.abs(found - wanted) < 4.5 * sigmas)


def test_positions_about_one_axis_do_not_tell_all() -> None:
    felt = np.array([felt_at(names, LATITUDE, G, EARTH)[:3] for names in DOCUMENT[:4]])
    good, _ = calibrated(felt, 1e-4, 6)
    assert not good


def test_directions_are_right_handed_axes() -> None:
    for names in DOCUMENT:
        axes = position_axes(names)
        assert np.linalg.det(axes) == pytest.approx(1.0)
        assert axes @ axes.T == pytest.approx(np.eye(3))
