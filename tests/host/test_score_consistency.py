"""NEES: draws from N(0, P) have mean 9."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from synthetic_drive import Errors, gnss, motion, solution, times

from host.score.consistency import departure, from_upper_triangle, nees
from host.score.rules import ScoringRules
from host.score.scorer import Scorer


def covariance(seed=2):
    rng = np.random.default_rng(seed)
    shape = rng.normal(size=(9, 9))
    scale = np.diag([1.0, 1.2, 2.0, 0.05, 0.06, 0.1, 0.004, 0.004, 0.01])
    P = scale @ (shape @ shape.T / 9 + np.eye(9)) @ scale
    return (P + P.T) / 2


def test_draws_from_the_covariance_have_mean_nine_and_the_chi_square_quantile():
    P = covariance()
    errors = np.random.default_rng(7).multivariate_normal(np.zeros(9), P, 4000)
    values = nees(errors, np.broadcast_to(P, (4000, 9, 9)))
    assert values.mean() == pytest.approx(9.0, abs=4 * np.sqrt(18 / 4000))
    assert np.quantile(values, 0.95) == pytest.approx(16.92, rel=0.04)
    np.testing.assert_allclose(values[0], errors[0] @ np.linalg.inv(P) @ errors[0], rtol=1e-9)


@pytest.mark.parametrize(("row", "column", "spoil"), [(4, 4, -1.0), (4, 4, 0.0), (2, 2, np.nan), (1, 2, 1.5)])
def test_a_covariance_that_is_not_positive_definite_gives_no_figure(row, column, spoil):
    P = np.tile(np.eye(9), (3, 1, 1))
    P[1, row, column] = P[1, column, row] = spoil
    np.testing.assert_allclose(nees(np.ones((3, 9)), P), [9.0, np.nan, 9.0])


def test_upper_triangle_is_row_by_row():
    P = covariance()
    packed = [P[i, j] for i in range(9) for j in range(i, 9)]
    np.testing.assert_array_equal(from_upper_triangle(np.array(packed)), P)


@pytest.mark.parametrize(("mean", "factor"), [(9.0, 1.0), (18.0, 2.0), (4.5, 2.0), (None, None)])
def test_departure_is_a_factor_either_way(mean, factor):
    assert departure(mean) == factor


@pytest.mark.parametrize(("sign", "honest"), [(1, True), (-1, False)])
def test_scored_nees_asks_for_the_sign_of_the_attitude_error(sign, honest):
    """Velocity and attitude errors correlated as the filter says: only the right sign gives 9."""
    P = np.diag([1.0, 1.0, 1.0, 0.04, 0.04, 0.04, 1e-4, 1e-4, 1e-4])
    P[3, 6] = P[6, 3] = 0.9 * np.sqrt(P[3, 3] * P[6, 6])
    count = 1500
    draws = np.random.default_rng(11).multivariate_normal(np.zeros(9), P, count)
    t = times(0, count, 1)
    truth = motion(t)
    true = Rotation.from_euler("ZYX", np.stack((truth.yaw, truth.pitch, truth.roll), axis=1))
    estimated = (Rotation.from_rotvec(sign * draws[:, 6:9]) * true).as_euler("ZYX")
    angles = estimated - np.stack((truth.yaw, truth.pitch, truth.roll), axis=1)
    scorer = Scorer(ScoringRules(0, 0))
    scorer.add_gnss(gnss(t), truth)
    for instant in t:
        scorer.add_covariance(float(instant), P)
    scorer.add_solution(solution(t, Errors(draws[:, 0:3], draws[:, 3:6], angles)), truth)
    metrics = scorer.result(float(count)).metrics
    assert metrics["nees_epochs"] >= count - 1
    if honest:
        assert metrics["nees_mean"] == pytest.approx(9.0, abs=0.6)
        assert metrics["nees_p95"] == pytest.approx(16.92, rel=0.08)
    else:
        assert metrics["nees_mean"] > 20
