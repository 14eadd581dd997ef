"""The gyro bias follows the chip's temperature, and a wrong reading does not move it."""

import copy

import numpy as np
import pytest
from nav_drive import Drive, make_drive, part, rows
from nav_run import run

from firmware.nav import layout as at
from firmware.nav.config import NavConfig

CONFIG = NavConfig(latency_sigma=0.0)
HOT = ("imu.temperature.rise_k=20.0", "imu.temperature.rise_time_s=300.0")


@pytest.fixture(scope="module")
def warming() -> Drive:
    """Ten minutes in which the sensor warms by 17 K."""
    return make_drive("town-open", 3, duration_s=600.0, overrides=HOT)


def with_temperature(drive: Drive, temperature: np.ndarray) -> Drive:
    """The same drive, told another temperature."""
    changed = copy.copy(drive)
    changed.temperature = temperature
    return changed


def test_coefficients_are_found(warming: Drive) -> None:
    """Against the bias and the temperature of the simulator, at either end of the drive."""
    result = run(warming, CONFIG)
    bias, kelvin = warming.truth.bias_g, warming.temperature[[100, -100]]
    true = (bias[-10] - bias[10]) / (kelvin[1] - kelvin[0])
    assert np.max(np.abs(true)) > 5.0e-4
    found = result.f[at.GYRO_PER_KELVIN : at.GYRO_PER_KELVIN + 3]
    np.testing.assert_allclose(found, true, atol=8.0e-5)


def test_temperature_keeps_the_bias_through_an_outage(warming: Drive) -> None:
    """Two minutes without GNSS nor aiding while it warms: what is told of the temperature is of use."""
    drive = part(warming, 0.0, 420.0)
    drive.epochs = [(t, e) for t, e in drive.epochs if t < 300 * 1_000_000_000]
    config = NavConfig(latency_sigma=0.0, constraint=False, standstill=False)
    k = -10
    errors = []
    for told in (drive.temperature, np.full(len(drive.times_ns), 25.0)):
        result = run(with_temperature(drive, told), config)
        errors.append(np.linalg.norm(result.biases[k, :3] - drive.truth.bias_g[len(result.t) + k]))
    assert errors[0] < 3.0e-4
    assert errors[1] > 4.0 * errors[0]


def test_wrong_reading_is_left_out(town: Drive) -> None:
    """One reading 64 K off, as by one bit, and a stretch of nonsense while the bus is disturbed."""
    spoilt = town.temperature.copy()
    spoilt[rows(town, 120.0, 120.99)] += 64.0
    nonsense = rows(town, 130.0, 140.0)
    spoilt[nonsense] = np.random.default_rng(1).uniform(-41.0, 87.0, nonsense.stop - nonsense.start)
    clean, disturbed = run(town, CONFIG), run(with_temperature(town, spoilt), CONFIG)
    np.testing.assert_allclose(disturbed.biases[:, :3], clean.biases[:, :3], atol=6.0e-5)
    assert np.max(np.abs(disturbed.position - clean.position)) < 0.05


def test_temperature_that_comes_late_moves_nothing(town: Drive) -> None:
    """Unknown for 100 s (each reading contradicts the one before), then told: the bias does not jump."""
    late = town.temperature.copy()
    until = rows(town, 0.0, 100.0)
    late[until] = np.linspace(-30.0, 500.0, until.stop - until.start)
    clean, other = run(town, CONFIG), run(with_temperature(town, late), CONFIG)
    after = clean.t > 100.0
    assert other.f[at.TEMPERATURE] == clean.f[at.TEMPERATURE]
    assert np.max(np.linalg.norm(other.biases[after, :3] - clean.biases[after, :3], axis=1)) < 2.0e-4
