"""The preset's numbers come out again when the fit described in it is repeated on the real Allan curves."""

import os
from pathlib import Path

import allantools
import numpy as np
import pytest
from scipy.optimize import nnls
from standing import sampled, world

from host.sim.errors.presets import load_preset

FOLDER = Path(os.environ.get("NAVTWIN_DATA", "")) / "bmi160_allan"
DPH = np.pi / 180 / 3600
MG = 9.80665e-3

pytestmark = [
    pytest.mark.recording,
    pytest.mark.skipif(
        not os.environ.get("NAVTWIN_DATA") or not FOLDER.is_dir(), reason="no bmi160_allan below NAVTWIN_DATA"
    ),
]


def markov_variance(tau, t):
    x = tau / t
    return 2 / x * (1 - (3 - 4 * np.exp(-x) + np.exp(-2 * x)) / (2 * x))


def fit(tau, deviation):
    """(N, σ, T, K) and the worst relative error of the curve."""
    best = None
    for t in np.geomspace(1, 1000, 40):
        terms = np.stack((1 / tau, tau / 3, tau * tau / 2, markov_variance(tau, t)), axis=1)
        squares, _ = nnls(terms / deviation[:, None] ** 2, np.ones(len(tau)))
        error = 0.5 * np.log(terms @ squares / deviation**2)
        if best is None or (error**2).sum() < best[0]:
            best = ((error**2).sum(), np.sqrt(squares), t, np.abs(error).max())
    _, (noise, walk, _, sigma), t, worst = best
    return noise, sigma, t, walk, worst


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("sensor", ["gyr", "acc"])
def test_the_fit_repeats(sensor, axis):
    tau = np.loadtxt(FOLDER / f"data_BMI160_{sensor}_t.txt")
    unit = DPH if sensor == "gyr" else 1.0
    deviation = np.loadtxt(FOLDER / f"data_BMI160_{sensor}_{'xyz'[axis]}.txt") * unit
    noise, sigma, t, walk, worst = fit(tau[tau > 0.1], deviation[tau > 0.1])
    preset = load_preset("bmi160")
    if sensor == "gyr":
        e = preset.gyro
        numbers = (e.noise_dps_per_rthz, e.instability_dph, e.instability_time_s, e.random_walk_dph_per_rts)
        units = (np.pi / 180, DPH, 1.0, DPH)
    else:
        e = preset.accelerometer
        numbers = (e.noise_ug_per_rthz, e.instability_mg, e.instability_time_s, e.random_walk_mg_per_rts)
        units = (1e-3 * MG, MG, 1.0, MG)
    density = np.sqrt(2) * noise  # single-sided
    for fitted, committed, scale in zip((density, sigma, t, walk), numbers, units, strict=True):
        assert fitted == pytest.approx(committed[axis] * scale, rel=0.01)
    assert worst < 0.15


@pytest.fixture(scope="module")
def at_rest():
    """Force and rate of half an hour at 100 Hz, (n, 7)."""
    return sampled(world(imu={"preset": "bmi160"}).imu("a"), 100, 1800, 50.0)


@pytest.mark.parametrize("channel", range(6))
def test_the_simulated_chip_lies_on_the_real_ones_curve(at_rest, channel):
    """Where white noise rules, the deviation of the simulated chip is the recorded one's."""
    sensor, unit = ("acc", 1.0) if channel < 3 else ("gyr", DPH)
    tau = np.loadtxt(FOLDER / f"data_BMI160_{sensor}_t.txt")
    real = np.loadtxt(FOLDER / f"data_BMI160_{sensor}_{'xyz'[channel % 3]}.txt") * unit
    asked = np.array([0.2, 0.5, 1.0, 2.0])
    found, simulated, *_ = allantools.oadev(at_rest[:, channel], rate=100.0, data_type="freq", taus=asked)
    expected = np.exp(np.interp(np.log(found), np.log(tau), np.log(real)))
    np.testing.assert_allclose(simulated, expected, rtol=0.15)
