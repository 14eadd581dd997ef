"""`navtwin simulate` with its inertial sensor off the vehicle's origin and turned in the body."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import simpson
from typer.testing import CliRunner

from host.cli.main import app

RATE_DPS, ARM_M = 40.0 * 6.0 / 5.5, 2.0
"""Flanks of 0.5 s keep the angle: between them the circle turns so much faster."""
DRIVE = """
segment = [
  { kind = "circle", duration_s = 6.0, rate_dps = 40.0 },
  { kind = "weave", duration_s = 6.0, amplitude_dps = 30.0, period_s = 2.0 },
]
place = { latitude_deg = 47.0, longitude_deg = 8.0 }
initial = { speed_mps = 5.0 }
imu = { preset = "perfect" }
"""


def samples(folder: Path, *more: str) -> Any:
    (folder / "drive.toml").write_text(DRIVE)
    made = str(folder / "drive.npz")
    result = CliRunner().invoke(app, ["simulate", str(folder / "drive.toml"), "-o", made, "-q", *more])
    assert result.exit_code == 0, result.output
    return np.load(made)["imu"]


def test_turning_pulls_outwards_at_the_end_of_a_lever_arm(tmp_path: Path) -> None:
    """−ω² l along the arm while the rate holds, whether samples are instants or increments."""
    pull = -(math.radians(RATE_DPS) ** 2) * ARM_M
    for kind, key, scale in (("instant", "force", 1.0), ("increment", "dv", 200.0)):
        there, here = (samples(tmp_path, "--samples", kind, "--imu-at", at) for at in ("2,0,0", "0,0,0"))
        more = (there[key] - here[key])[600] * scale
        assert more[0] == pytest.approx(pull, rel=1e-3)
        assert np.abs(more[1:]).max() < 1e-3
        np.testing.assert_array_equal(there["latitude"], here["latitude"])


def test_increments_at_a_lever_arm_are_the_integral_of_instants_there(tmp_path: Path) -> None:
    """Where the turn rate changes, and with it the force across the arm."""
    fine = samples(tmp_path, "--imu-at", "2,0.5,0", "--rate", "1600")
    coarse = samples(tmp_path, "--imu-at", "2,0.5,0", "--samples", "increment")
    k = 1700
    stretch = slice(8 * k, 8 * (k + 1) + 1)
    expected = simpson(fine["force"][stretch], dx=1 / 1600, axis=0)
    np.testing.assert_allclose(coarse["dv"][k], expected, atol=1e-10)


def test_a_turned_sensor_feels_along_its_own_axes(tmp_path: Path) -> None:
    """A quarter to the right: its x is the body's y, its y is the body's −x; upside down: y and z are."""
    straight = samples(tmp_path)
    right = samples(tmp_path, "--mounting", "90,0,0")
    over = samples(tmp_path, "--mounting", "0,0,180")
    for key in ("force", "rate"):
        x, y, z = straight[key].T
        np.testing.assert_allclose(right[key], np.column_stack((y, -x, z)), atol=1e-12)
        np.testing.assert_allclose(over[key], np.column_stack((x, -y, -z)), atol=1e-12)


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (("--imu-at", "1,2"), "--imu-at 1,2: must be three lengths"),
        (("--mounting", "90"), "--mounting 90: must be yaw, pitch, roll"),
        (("--mounting", "0,91,0"), "within ±360, 90, 180"),
        (("--mounting", "0,nan,0"), "e.g. --mounting 90,0,180"),
    ],
)
def test_mistakes_are_one_message(more: tuple[str, ...], words: str) -> None:
    result = CliRunner().invoke(app, ["simulate", "town-open", *more])
    assert result.exit_code == 2, result.output
    assert words in result.stderr
