"""`navtwin allan`: set noise is found again, curves of known noise, and files that make no curve."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from host.cli.main import app
from host.sim.scenario.load import scenario_from
from host.sim.simulated import SimulatedVehicle
from host.simulate.allan import curve_of, identified

REST = "[place]\nlatitude_deg = 30.0\nlongitude_deg = 114.0\n"
DEG = math.pi / 180.0
GRADES = {  # °/√h, m/s/√h of the sources that the presets name
    "pos830": (0.0022, 0.00075),
    "stim300": (0.15, 0.07),
    "adis16488": (0.26, 0.029),
}


def navtwin(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(one) for one in arguments])


def record(
    folder: Path, preset: str, seconds: float, rate: float, name: str = "rest.npz", seed: int = 1
) -> Path:
    (folder / "rest.toml").write_text(REST)
    more = ("--set", f"duration_s={seconds}", "--set", f"imu.preset={preset}", "--gnss-rate", 0)
    result = navtwin(
        "simulate", folder / "rest.toml", *more, "--rate", rate, "--seed", seed, "-o", folder / name, "-q"
    )
    assert result.exit_code == 0, result.output
    return folder / name


def channels(file: Path) -> dict[str, dict[str, Any]]:
    result = navtwin("allan", file, "--json", "-", "-q")
    assert result.exit_code == 0, result.output
    return {one["channel"]: one for one in json.loads(result.stdout)["channels"]}


@pytest.mark.parametrize("preset", GRADES)
def test_random_walks_of_three_grades_are_found_within_two_percent(tmp_path: Path, preset: str) -> None:
    found = channels(record(tmp_path, preset, 1800.0, 100.0))
    angle, velocity = GRADES[preset]
    for axis in "xyz":
        assert found[f"gyro_{axis}"]["random_walk"] * 60.0 / DEG == pytest.approx(angle, rel=0.02)
        assert found[f"accel_{axis}"]["random_walk"] * 60.0 == pytest.approx(velocity, rel=0.02)


def test_increments_and_other_formats_give_the_same_curve(tmp_path: Path) -> None:
    plain = channels(record(tmp_path, "stim300", 300.0, 100.0, "rest.csv"))
    (tmp_path / "rest.toml").write_text(REST)
    for name, form in (("k.txt", "kf-gins"), ("p.csv", "pyins")):
        more = ("--set", "duration_s=300.0", "--set", "imu.preset=stim300", "--rate", 100)
        assert (
            navtwin("simulate", tmp_path / "rest.toml", *more, "-o", tmp_path / name, "-f", form).exit_code
            == 0
        )
    for other in (channels(tmp_path / "k.imu.txt"), channels(tmp_path / "p.imu.csv")):
        for name, one in plain.items():
            assert other[name]["random_walk"] == pytest.approx(one["random_walk"], rel=0.02), name


def test_coefficients_of_a_curve_on_paper() -> None:
    """White noise, a Gauss–Markov process and a random walk, put together by their formulas."""
    tau = np.geomspace(0.01, 2000.0, 80)
    noise, sigma, time_s, walk = 3e-4, 2e-5, 60.0, 4e-7
    x = tau / time_s
    markov = 2 * sigma**2 / x * (1 - (3 - 4 * np.exp(-x) + np.exp(-2 * x)) / (2 * x))
    found, fit = identified(tau, np.sqrt(noise**2 / tau + markov + walk**2 * tau / 3), 18_000.0)
    assert found.random_walk == pytest.approx(noise, rel=0.01)
    assert found.markov == pytest.approx(sigma, rel=0.05)
    assert found.markov_time_s == pytest.approx(time_s, rel=0.25)
    assert found.rate_random_walk == pytest.approx(walk, rel=0.1)
    assert found.quantisation == pytest.approx(0.0, abs=1e-7)
    assert found.worst_misfit < 0.02
    assert len(fit) == 80


def test_the_curve_is_that_of_the_definition() -> None:
    """σ²(τ) = ½ ⟨(mean over τ − mean over the next τ)²⟩, over all starts, by plain loops."""
    values = np.random.default_rng(3).standard_normal(4000).cumsum()
    curve = curve_of("gyro_x", values, 10.0)
    sums = np.concatenate(([0.0], np.cumsum(values)))
    for tau, deviation in list(zip(curve.tau_s.tolist(), curve.deviation.tolist(), strict=True))[::7]:
        m = round(tau * 10)
        means = (sums[m:] - sums[:-m]) / m
        differences = means[m:] - means[:-m]
        assert deviation == pytest.approx(math.sqrt(0.5 * np.mean(differences**2)), rel=1e-3)


def test_page_and_set_values(tmp_path: Path) -> None:
    file = record(tmp_path, "stim300", 200.0, 50.0)
    result = navtwin("allan", file, "--preset", "stim300", "-o", tmp_path / "allan.html")
    assert result.exit_code == 0, result.output
    assert "set by stim300" in " ".join(result.output.split())
    page = (tmp_path / "allan.html").read_text()
    assert "Accelerometers" in page
    assert "<script src" not in page


def table(*lines: str) -> str:
    return "\n".join(("t_s,gyro_x", *lines)) + "\n"


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("x.csv", "a,b\n1,2\n", "line 1: needs a column t_s"),
        ("x.csv", "t_s,gyro_x\n1,2\n", "holds 1 samples"),
        (
            "x.csv",
            "t_s,gyro_x\n" + "\n".join(f"{k},{k % 3}" for k in [*range(900), *range(1200, 1500)]),
            "sample 901",
        ),
        (
            "x.csv",
            "t_s,gyro_x\n" + "\n".join(f"{k},nan" for k in range(1100)),
            "sample 1: gyro_x is nan, no finite number",
        ),
        ("x.csv", "t_s,gyro_x\n" + "\n".join(f"{k},up" for k in range(1100)), "line 2: 'up' is not a number"),
        ("x.csv", "t_s,gyro_x,gyro_y\n" + "0,1,2\n" * 7 + "0,1\n", "line 9: 2 values; column 3 is read"),
        ("x.csv", "t_s,gyro_x\n" + "\n".join(f"{k},1" for k in range(1100)), "gyro_x is 1 in all samples"),
        ("x.csv", "t_s,gyro_x\n" + "\n".join(f"{k},{k}e200" for k in range(1100)), "gyro_x is 1.099e+203"),
        ("x.csv", "t_s,gyro_x\n", "holds 0 samples"),
        ("x.csv", "t_s,gyro_x,gyro_x\n0,1,1\n", "column gyro_x is there twice"),
        ("x.csv", "t_s,rate_x_radps,dv_x_mps\n0,1,1\n", "rates and increments"),
        ("x.npz", "", "is not what navtwin simulate writes"),
        ("x.npz", "PK", "is not what navtwin simulate writes"),
        ("x.txt", "1 2 3\n", "has 3 columns"),
        ("x.doc", "", "none of .npz"),
    ],
)
def test_what_makes_no_curve_is_one_message(tmp_path: Path, name: str, content: str, words: str) -> None:
    (tmp_path / name).write_text(content)
    result = navtwin("allan", tmp_path / name, "-o", tmp_path / "page.html")
    assert result.exit_code == 2, result.output
    assert words in result.stderr
    assert result.stderr.count("\n") == 1
    assert not (tmp_path / "page.html").exists()


def test_unknown_preset_and_missing_file(tmp_path: Path) -> None:
    assert "did you mean 'stim300'" in navtwin("allan", tmp_path / "x.npz", "--preset", "stim30").stderr
    assert "no such file" in navtwin("allan", tmp_path / "x.npz").stderr


@pytest.mark.soak
def test_gauss_markov_biases_over_twenty_seeds() -> None:
    """45 h hold eleven correlation times: single runs scatter by a fifth. The Allan variance has no bias, so
    the process is found in the mean of twenty; above 200 s, as these are instants and no means over 10 s."""
    times_ns = np.arange(16_200) * 10_000_000_000
    variances: dict[str, list[Any]] = {"gyro": [], "accel": []}
    for seed in range(1, 21):
        data = {"place": {"latitude_deg": 30.0, "longitude_deg": 114.0}, "duration_s": 162_000.0}
        scenario = scenario_from(data | {"imu": {"preset": "stim300"}}, "rest", "rest")
        slow = SimulatedVehicle(scenario, seed).imu("imu", np.eye(3), np.zeros(3)).slow_errors(times_ns)
        for kind, first in (("gyro", 0), ("accel", 3)):
            for axis in range(3):
                curve = curve_of(f"{kind}_x", slow[:, first + axis], 0.1)
                variances[kind].append(curve.deviation**2)
    known = curve.tau_s >= 200.0
    for kind, set_value in (("gyro", 0.5 * DEG / 3600.0), ("accel", 50e-5)):
        deviation = np.sqrt(np.mean(variances[kind], axis=0))
        found, _ = identified(curve.tau_s[known], deviation[known], 162_000.0)
        assert found.markov == pytest.approx(set_value, rel=0.05)
