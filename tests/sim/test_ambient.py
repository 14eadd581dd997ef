"""Magnetometer and barometer of `navtwin simulate`, against published values of both models."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pygeomag import GeoMag
from typer.testing import CliRunner, Result

from host.cli.main import app

TABLE = """
segment = [{ kind = "rotary-table", dwell_s = 1.0, move_s = 2.0 }]
[place]
latitude_deg = 47.05
longitude_deg = 8.31
height_m = 440.0
geoid_separation_m = 47.0
"""
DRIVE = """
segment = [
  { kind = "reach-speed", duration_s = 5.0, to_mps = 200.0 },
  { kind = "cruise", duration_s = 295.0, pitch_to_deg = 4.0 },
]
[place]
latitude_deg = 46.98
longitude_deg = 179.9
[initial]
yaw_deg = 60.0
"""


@pytest.fixture
def table(tmp_path: Path) -> Path:
    path = tmp_path / "table.toml"
    path.write_text(TABLE)
    return path


def simulate(*arguments: object) -> Result:
    return CliRunner().invoke(app, ["simulate", *map(str, arguments), "-q"])


def made(scenario: Path, *more: object) -> Any:
    path = scenario.parent / "out.npz"
    result = simulate(scenario, "-o", path, *more)
    assert result.exit_code == 0, result.output
    return np.load(path)


def axes(rows: Any, name: str) -> Any:
    return np.column_stack([rows[f"{name}_{axis}_ut"] for axis in "xyz"])


def changes(**values: object) -> list[str]:
    return [part for key, value in values.items() for part in ("--set", f"{key.replace('__', '.')}={value}")]


@pytest.mark.parametrize(
    ("latitude", "longitude", "height", "field"),
    [
        (80.0, 0.0, 0.0, (6570.4, -146.3, 54606.0)),
        (0.0, 120.0, 0.0, (39624.3, 109.9, -10932.5)),
        (-80.0, -120.0, 0.0, (5940.6, 15772.1, -52480.8)),
    ],
)
def test_field_is_that_of_the_published_test_values_of_the_model(
    table: Path, latitude: float, longitude: float, height: float, field: tuple[float, float, float]
) -> None:
    """WMM2020, test values for 2020.0, nT."""
    here = changes(place__latitude_deg=latitude, place__longitude_deg=longitude, place__height_m=height)
    mag = made(table, "--mag-rate", 1, *here, *changes(start__utc='"2020-01-01T00:00:00Z"'))["mag"]
    np.testing.assert_allclose(axes(mag, "true_field")[0] * 1000.0, field, atol=0.3)
    np.testing.assert_array_equal(axes(mag, "true_field"), axes(mag, "field"))


def test_field_along_a_flight_is_the_model_turned_into_the_body(tmp_path: Path) -> None:
    """Over the date line, with the model asked at every instant; heading and attitude from the truth."""
    path = tmp_path / "flight.toml"
    path.write_text(DRIVE)
    data = made(path, "--mag-rate", 1, "--rate", 1, "--gnss-rate", 0)
    model = GeoMag(coefficients_file="wmm/WMM_2020.COF")
    imu, mag = data["imu"], axes(data["mag"], "true_field") * 1000.0
    worst = 0.0
    for row, felt in zip(imu[::7], mag[::7], strict=True):
        lat, lon = np.degrees([row["latitude"], row["longitude"]])
        found = model.calculate(
            glat=lat, glon=(lon + 180.0) % 360.0 - 180.0, alt=row["height"] / 1000.0, time=2024 + 134.3 / 366
        )
        yaw, pitch = row["yaw"], row["pitch"]
        ahead = found.x * np.cos(yaw) + found.y * np.sin(yaw)
        right = found.y * np.cos(yaw) - found.x * np.sin(yaw)
        expected = (
            ahead * np.cos(pitch) - found.z * np.sin(pitch),
            right,
            found.z * np.cos(pitch) + ahead * np.sin(pitch),
        )
        worst = max(worst, float(np.max(np.abs(felt - expected))))
    assert np.degrees(imu["longitude"][0]) > 178.0  # it did cross
    assert np.degrees(imu["longitude"][-1]) < -179.0
    assert worst < 0.1


def test_hard_and_soft_iron_are_found_again_by_least_squares(table: Path) -> None:
    soft = [[1.1, 0.05, 0.0], [-0.02, 0.9, 0.03], [0.0, 0.01, 1.05]]
    more = changes(magnetometer__hard_iron_ut=[5.0, -8.0, 3.0], magnetometer__soft_iron=soft)
    noisy = changes(magnetometer__noise_ut=0.2)
    mag = made(table, "--mag-rate", 100, *more, *noisy)["mag"]
    true, felt = axes(mag, "true_field"), axes(mag, "field")
    known = np.column_stack((true, np.ones(len(true))))
    found, *_ = np.linalg.lstsq(known, felt, rcond=None)
    np.testing.assert_allclose(found[:3].T, soft, atol=0.002)
    np.testing.assert_allclose(found[3], [5.0, -8.0, 3.0], atol=0.05)
    assert (felt - known @ found).std() == pytest.approx(0.2, rel=0.05)
    np.testing.assert_allclose(np.linalg.norm(true, axis=1), np.linalg.norm(true[0]), rtol=1e-6)
    drawn = [
        axes(
            made(table, "--mag-rate", 1, "--seed", seed, *changes(magnetometer__hard_iron_error_ut=2.0))[
                "mag"
            ],
            "field",
        )[0]
        for seed in (1, 2)
    ]
    assert np.all(np.abs(drawn[0] - drawn[1]) > 1e-3)


@pytest.mark.parametrize(
    ("height", "pressure"), [(0.0, 101325.0), (1000.0, 89876.0), (5000.0, 54048.0), (10_000.0, 26500.0)]
)
def test_pressure_is_that_of_the_published_atmosphere(table: Path, height: float, pressure: float) -> None:
    """U.S. Standard Atmosphere 1976, table I, by geometric height."""
    here = changes(place__height_m=height + 47.0)
    baro = made(table, "--baro-rate", 1, *here)["baro"]
    assert baro["pressure_pa"][0] == pytest.approx(pressure, rel=5e-5)
    np.testing.assert_allclose(baro["true_height_msl_m"], height, atol=1e-3)
    np.testing.assert_allclose(baro["pressure_height_m"], height, atol=1e-3)


def test_errors_of_the_barometer(table: Path) -> None:
    rest = ("--baro-rate", 50, *changes(segment="[]", duration_s=2000.0), "--rate", 1, "--gnss-rate", 0)
    plain = made(table, *rest)["baro"]["pressure_pa"]
    noise = made(table, *rest, *changes(barometer__noise_pa=3.0, barometer__bias_pa=50.0))["baro"]
    assert np.mean(noise["pressure_pa"] - plain) == pytest.approx(50.0, abs=0.05)
    assert np.std(noise["pressure_pa"] - plain) == pytest.approx(3.0, rel=0.02)
    drift = made(table, *rest, *changes(barometer__drift_pa=20.0, barometer__drift_time_s=5.0))["baro"]
    assert np.std(drift["pressure_pa"] - plain) == pytest.approx(20.0, rel=0.2)
    low = made(table, *rest, *changes(barometer__sea_level_hpa=1000.0))["baro"]
    assert low["pressure_height_m"][0] - 393.0 == pytest.approx(112.0, abs=3.0)  # 8.4 m per hPa


def test_every_format_holds_them_and_blocks_leave_no_trace(
    table: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    noisy = changes(magnetometer__noise_ut=0.2, barometer__noise_pa=2.0, barometer__drift_pa=5.0)
    rates = ("--mag-rate", "12.5", "--baro-rate", 7)
    data = made(table, *rates, *noisy)
    monkeypatch.setattr("host.simulate.stream.BLOCK", 77)
    again = made(table, *rates, *noisy)
    monkeypatch.undo()
    for name, count in (("mag", 12.5), ("baro", 7.0)):
        np.testing.assert_array_equal(data[name], again[name])
        assert len(data[name]) == int(count * data["imu"]["t_ns"][-1] / 1e9) + 1
    for form, name in (("csv", "a.csv"), ("pyins", "b.csv"), ("kf-gins", "c.txt")):
        result = simulate(table, "-o", table.parent / name, "-f", form, *rates, *noisy)
        assert result.exit_code == 0, result.output
        written = np.genfromtxt(table.parent / f"{name[0]}.mag.csv", delimiter=",", names=True)
        np.testing.assert_allclose(written["field_y_ut"], data["mag"]["field_y_ut"], atol=1e-6)
    result = simulate(table, "-o", table.parent / "d.mcap", *rates, *noisy)
    assert result.exit_code == 0, result.output
    assert b"/mag" in (table.parent / "d.mcap").read_bytes()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--mag-rate", "-1"], "--mag-rate -1: must lie in"),
        (["--baro-rate", "x"], "--baro-rate x: is not a number"),
        (["--mag-rate", "1", *changes(start__utc='"2031-01-01T00:00:00Z"')], "no World Magnetic Model"),
        (["--mag-rate", "1", *changes(start__utc='"2009-12-31T23:00:00Z"')], "no World Magnetic Model"),
        (changes(magnetometer__soft_iron="[[1, 0], [0, 1]]"), "soft_iron"),
        (changes(magnetometer__noise_ut=-1), "noise_ut"),
        (changes(barometer__sea_level_hpa=10), "sea_level_hpa"),
        (changes(barometer__dirft_pa=10), "dirft_pa"),
    ],
)
def test_mistakes_are_told_in_one_message(table: Path, arguments: list[str], words: str) -> None:
    result = simulate(table, *arguments)
    assert result.exit_code == 2, result.output
    assert words in result.output
