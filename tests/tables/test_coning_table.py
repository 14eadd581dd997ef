"""`navtwin table coning` against the closed form and the theory of updates that sum angles."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

from host.cli.main import app
from host.sim.earth import EARTH_RATE
from host.tables.coning import LATITUDE, Coning


@pytest.fixture(scope="module")
def told() -> dict[str, Any]:
    arguments = ["table", "coning", "--duration", "6", "--json", "-", "-q"]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    found: dict[str, Any] = json.loads(result.stdout)
    return found


def drift(told: dict[str, Any], update: str, arithmetic: str) -> float:
    found = [one for one in told["updates"] if (one["update"], one["arithmetic"]) == (update, arithmetic)]
    return float(found[0]["drift_deg"])


def test_exact_rates_turn_into_the_closed_form() -> None:
    """Rates less the Earth's, integrated finely by another library, are the attitude."""
    coning = Coning(duration_s=0.2, period=2e-5)
    rates = coning.samples()[:, :3]
    times = 0.5 * coning.period * np.arange(len(rates))
    attitude = Rotation.from_quat(coning.attitude(times)[:, [1, 2, 3, 0]])
    earth = np.array((EARTH_RATE * math.cos(LATITUDE), 0.0, -EARTH_RATE * math.sin(LATITUDE)))
    felt = rates - attitude.inv().apply(earth)
    step = 0.5 * coning.period
    reached = attitude[0]
    for middle in 0.5 * (felt[:-1] + felt[1:]):
        reached = reached * Rotation.from_rotvec(middle * step)
    assert (reached.inv() * attitude[-1]).magnitude() < 1e-8


@pytest.mark.parametrize("arithmetic", ["float32", "fixed", "float64"])
def test_updates_that_sum_angles_drift_as_theory_says(told: dict[str, Any], arithmetic: str) -> None:
    """The sum comes from a parabola through three rates here: it leaves 0.2 % of the amplitude out."""
    known = math.degrees(Coning(duration_s=6.0).drift_of_summed_angles)
    for order in (1, 2, 3, 4):
        assert drift(told, f"rotation_vector_{order}", arithmetic) == pytest.approx(known, rel=0.003)


@pytest.mark.parametrize("arithmetic", ["float32", "fixed", "float64"])
@pytest.mark.parametrize("update", ["rk4", "two_sample", "euler_angles", "direction_cosines"])
def test_updates_that_know_coning_drift_a_hundred_times_less(
    told: dict[str, Any], update: str, arithmetic: str
) -> None:
    assert drift(told, update, arithmetic) < 0.01 * drift(told, "rotation_vector_4", arithmetic)


def test_drift_grows_with_time_and_with_the_square_of_the_angle(told: dict[str, Any]) -> None:
    for one in told["updates"]:
        if one["closed_form_deg"] is not None:
            assert one["error_deg"][-1] == pytest.approx(6 * one["error_deg"][0], rel=0.01)
    arguments = [
        "table",
        "coning",
        "--duration",
        "6",
        "--half-angle",
        "2",
        "-a",
        "float64",
        "--json",
        "-",
        "-q",
    ]
    wider = json.loads(CliRunner().invoke(app, arguments).stdout)
    ratio = drift(wider, "rotation_vector_4", "float64") / drift(told, "rotation_vector_4", "float64")
    assert ratio == pytest.approx(4.0, rel=0.002)


def test_page_and_table(tmp_path: Path) -> None:
    page = tmp_path / "coning.html"
    arguments = ["table", "coning", "--duration", "1", "-a", "float32", "-o", str(page)]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0
    assert "Runge-Kutta 4 (2-37)" in result.output
    assert 'id="coning-float32"' in page.read_text()
