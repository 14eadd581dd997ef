"""`navtwin evaluate`: the drift without a receiver is the sensor's, and the filter knows how large it is."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats
from typer.testing import CliRunner, Result

from host.cli.main import app

STREETS = """
segment = [
  { kind = "rest", duration_s = 20.0 },
  { kind = "reach-speed", duration_s = 8.0, to_mps = 12.0 },
  { kind = "turn", duration_s = 9.0, angle_deg = 90.0 },
  { kind = "cruise", duration_s = 20.0 },
  { kind = "turn", duration_s = 9.0, angle_deg = -70.0 },
  { kind = "reach-speed", duration_s = 8.0, to_mps = 0.0 },
]
[place]
latitude_deg = 47.05
longitude_deg = 8.31
[imu]
preset = "bmi160"
[[outage]]
start_s = 1.0
duration_s = 70.0
"""


@pytest.fixture
def streets(tmp_path: Path) -> Path:
    path = tmp_path / "streets.toml"
    path.write_text(STREETS)
    return path


def evaluate(*arguments: object) -> Result:
    return CliRunner().invoke(app, ["evaluate", *map(str, arguments)])


def figures(*arguments: object) -> tuple[int, dict[str, Any]]:
    result = evaluate(*arguments, "--json", "-", "-q")
    assert result.exit_code in (0, 1), result.output
    return result.exit_code, json.loads(result.stdout)


def sensors(told: dict[str, Any]) -> dict[str, dict[str, Any]]:
    return {one["preset"]: one for one in told["sensors"]}


def test_without_sensor_errors_nothing_drifts_but_what_the_receiver_left(streets: Path) -> None:
    _, told = figures(streets, "-p", "perfect", "--drives", 1, "--outages", 3, "--length", 60, "--gap", 20)
    assert sensors(told)["perfect"]["horizontal_rms_m"] < 0.03


@pytest.mark.soak
def test_filter_knows_how_far_each_grade_drifts(streets: Path) -> None:
    """Truth is the judge: error² over covariance of 2 × 24 components has its 99.9 % between 0.45 and 1.8,
    less independent ones a little more."""
    presets = ("pos830", "stim300", "adis16488")
    options = [part for name in presets for part in ("-p", name)]
    code, told = figures(streets, *options, "--drives", 1, "--outages", 24, "--length", 30, "--gap", 20)
    assert code == 0  # 30 s were not published
    found = sensors(told)
    for one in found.values():
        ratio = (one["horizontal_rms_m"] / one["expected_horizontal_rms_m"]) ** 2
        assert 0.4 < ratio < 2.0, one["preset"]
        assert (one["agrees"], one["band_m"], len(one["horizontal_m"])) == (None, None, 24)
        assert one["horizontal_rms_m"] == pytest.approx(np.sqrt(np.mean(np.square(one["horizontal_m"]))))
    drifts = [found[name]["horizontal_rms_m"] for name in presets]
    assert drifts[0] * 5 < drifts[1] < drifts[2]


def test_filter_knows_biases_that_stay(streets: Path) -> None:
    """Drawn at switch-on, 0.5 °/s and 10 °/h: they neither go back to nothing nor surprise the filter."""
    options = ("--drives", 1, "--outages", 6, "--length", 30, "--gap", 20)
    found = sensors(figures(streets, "-p", "bmi160", "-p", "tactical-grade", *options)[1])
    for name, most_m in (("bmi160", 100.0), ("tactical-grade", 20.0)):
        one = found[name]
        assert one["horizontal_rms_m"] < 1.5 * one["expected_horizontal_rms_m"], name
        assert one["horizontal_rms_m"] < most_m, name


def test_verdict_page_and_exit_code(streets: Path, tmp_path: Path) -> None:
    page = tmp_path / "drift.html"
    options = (streets, "-p", "stim300", "-p", "bmi160", "--drives", 2, "--outages", 1, "--gap", 10)
    result = evaluate(*options, "-o", page, "--json", tmp_path / "drift.json")
    told = sensors(json.loads((tmp_path / "drift.json").read_text()))
    low, high = told["stim300"]["band_m"]
    assert (low, high) == (pytest.approx(4.779 / 1.5), pytest.approx(7.239 * 1.5))
    agrees = low <= told["stim300"]["horizontal_rms_m"] <= high
    assert (told["stim300"]["agrees"], told["bmi160"]["agrees"]) == (agrees, None)
    assert result.exit_code == (0 if agrees else 1)
    assert ("NOT MET" in result.output) != agrees
    text = page.read_text()
    assert "stim300" in text
    assert "src=" not in text.split("<script>")[0]
    again = evaluate(*options, "-o", tmp_path / "again.html", "-q")
    assert again.exit_code == result.exit_code
    assert (tmp_path / "again.html").read_bytes() == page.read_bytes()


@pytest.mark.soak
def test_figure_is_that_of_all_drives_and_its_interval_that_of_their_scatter(streets: Path) -> None:
    """Each drive by itself is the command with that seed; Student's interval by SciPy, of the mean square."""
    options = (streets, "-p", "stim300", "--outages", 3, "--length", 20, "--gap", 10)
    one = sensors(figures(*options, "--drives", 3, "--seed", 4)[1])["stim300"]
    alone = [sensors(figures(*options, "--drives", 1, "--seed", seed)[1])["stim300"] for seed in (4, 5, 6)]
    assert one["horizontal_m"] == [end for single in alone for end in single["horizontal_m"]]
    assert one["each_drive_rms_m"] == [single["horizontal_rms_m"] for single in alone]
    assert alone[0]["interval_95_m"] is None
    ends = np.array(one["horizontal_m"])
    assert one["horizontal_rms_m"] == pytest.approx(np.sqrt(np.mean(ends**2)))
    squares = np.array(one["each_drive_rms_m"]) ** 2
    low, high = stats.t.interval(0.95, 2, loc=1.0, scale=stats.sem(squares) / squares.mean())
    shares = 2.0 * np.log(np.array(one["interval_95_m"]) / one["horizontal_rms_m"])
    np.testing.assert_allclose(shares, (low - 1.0, high - 1.0), rtol=1e-9)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["no-such"], "no board has such a scenario"),
        (["real-drive"], "is a recording"),
        (["-p", "bmi106"], "did you mean 'bmi160'"),
        (["--drives", "0"], "--drives 0: must lie in"),
        (["--outages", "0"], "--outages 0: must lie in"),
        (["--length", "-3"], "--length -3: must lie in"),
        (["--gap", "x"], "gap"),
        (["--outages", "1000", "--length", "3600"], "make a drive of"),
        (["-o", "no/such/x.html"], "does not exist"),
    ],
)
def test_mistakes_are_told_in_one_message(arguments: list[str], words: str) -> None:
    result = evaluate(*arguments)
    assert result.exit_code == 2, result.output
    assert words in result.output
    assert "Traceback" not in result.output


def test_a_drive_that_cannot_be_driven_again_is_told(streets: Path) -> None:
    streets.write_text(STREETS.replace("to_mps = 0.0", "to_mps = 9.0"))
    result = evaluate(streets, "--outages", 2, "--gap", 120)
    assert result.exit_code == 2
    assert "lasts 74 s, the test 541 s; to be driven again it must end" in result.output
