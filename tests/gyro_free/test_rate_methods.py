"""Angular rate from nine accelerometers against rigid-body motion in closed form."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware.nav.gyro_free import layout as at
from firmware.nav.gyro_free.config import GyroFreeConfig, new_sensor
from firmware.nav.gyro_free.rates import rate_step
from host.tables.rate_methods import METHODS, rate_row
from host.tables.rate_motion import ROTATIONS, SENSORS

ARM = 0.25
PLACES = ARM * np.array(
    [[0, 1, 0], [0, 0, 1], [1, 0, 0], [0, 0, -1], [-1, 0, 0], [0, -1, 0], [0, 0, 0], [0, 0, 0], [0, 0, 0]]
)
"""Of A1 … A9, as the board's document has them."""
vectors = st.lists(st.floats(-10.0, 10.0), min_size=3, max_size=3).map(np.array)


@settings(deadline=None)
@given(vectors, vectors, vectors)
def test_rotation_is_resolved_exactly(force: np.ndarray, rate: np.ndarray, change: np.ndarray) -> None:
    g, n = new_sensor(GyroFreeConfig(arm_length=ARM))
    felt = force + np.cross(change, PLACES) + np.cross(rate, np.cross(rate, PLACES))
    g[:9] = felt[np.arange(9), np.arange(9) % 3]
    assert rate_step(g, n, 0.005)
    close = {"abs": 5e-4, "rel": 1e-5}
    assert g[at.ANGULAR_ACCELERATION : at.ANGULAR_ACCELERATION + 3] == pytest.approx(change, **close)
    wanted = (rate[0] * rate[1], rate[1] * rate[2], rate[0] * rate[2])
    assert g[at.PRODUCTS : at.PRODUCTS + 3] == pytest.approx(wanted, **close)
    assert g[at.FORCE : at.FORCE + 3] == pytest.approx(force, abs=1e-5)


@settings(deadline=None, max_examples=60)
@given(
    st.sampled_from(METHODS),
    st.lists(st.lists(st.floats(width=32), min_size=9, max_size=9), min_size=1, max_size=12),
)
def test_no_sample_makes_a_rate_that_is_no_number(method: str, samples: list[list[float]]) -> None:
    g, n = new_sensor(GyroFreeConfig(method=method))
    for sample in samples:
        g[:9] = np.array(sample, np.float32)
        rate_step(g, n, 0.005)
        assert np.all(np.isfinite(g[at.OMEGA : at.OMEGA + 3]))
    covariance = g[at.FUSED_COVARIANCE : at.FUSED_COVARIANCE + 9].reshape(3, 3).astype(float)
    assert np.all(np.isfinite(covariance))
    g[:9] = 0.0
    assert rate_step(g, n, 0.005)


@pytest.mark.parametrize("sensors", [SENSORS[0], SENSORS[2]], ids=lambda one: one.name)
@pytest.mark.parametrize("rotation", ROTATIONS, ids=lambda one: one.name)
def test_fused_is_as_good_as_the_best(rotation, sensors) -> None:  # type: ignore[no-untyped-def]
    row = rate_row(rotation, sensors, ARM, 20.0, (31, 32))
    best = min(row.error[method] for method in METHODS if method != "fused")
    if sensors.noisy and rotation.name.startswith("about all axes"):
        assert row.must_win
        assert row.error["fused"] < 0.7 * best
    assert row.error["fused"] <= 1.05 * best
    assert row.met


def test_an_integral_walks_as_white_noise_makes_it() -> None:
    """σ_ω = σ_ω̇ √(Δt t): 4.1 mg on arms of 0.25 m."""
    rng = np.random.default_rng(4)
    ends = []
    for _ in range(30):
        g, n = new_sensor(GyroFreeConfig(method="integration"))
        for sample in rng.normal(0.0, 0.04, (400, 9)).astype(np.float32):
            g[:9] = sample
            rate_step(g, n, 0.005)
        ends.append(g[at.OMEGA : at.OMEGA + 3].copy())
    expected = 0.04 / ARM * np.sqrt(0.005 * 2.0)
    assert np.std(ends) == pytest.approx(expected, rel=0.25)


@pytest.mark.parametrize(
    ("field", "value"),
    [("arm_length", 0.0), ("method", "best"), ("scales", (1.0,)), ("declination", float("nan"))],
)
def test_a_wrong_configuration_says_which_field(field: str, value: object) -> None:
    with pytest.raises(ValueError, match=f"GyroFreeConfig.{field}"):
        new_sensor(GyroFreeConfig(**{field: value}))
