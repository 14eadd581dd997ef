"""`navtwin simulate` of drives and faults that cannot be: one message with the file, nothing is written."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from host.cli.main import app

PLACE = "[place]\nlatitude_deg = 47.0\nlongitude_deg = 8.0\n"
STAND = 'segment = [{ kind = "rest", duration_s = 5.0 }]\n' + PLACE


def segments(*told: str, place: str = PLACE) -> str:
    return "segment = [" + ", ".join(f"{{ {one} }}" for one in told) + "]\n" + place


def fault(kind: str) -> str:
    return f'{STAND}[[fault]]\nkind = "{kind}"\ntarget = "gnss"\nat_s = 1.0\n'


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (f"[trajectory]\nmatrix = [[2, 5]]\n{PLACE}", "row 1 [2, 5]: type 2 needs 3 columns"),
        (f"[trajectory]\nmatrix = []\n{PLACE}", "trajectory.matrix = []"),
        (
            segments('kind = "accelerate", duration_s = 900.0, acceleration_mps2 = 10.0'),
            "to 9,000 m/s; at most 3,000",
        ),
        (
            segments('kind = "reach-speed", duration_s = 1e-3, to_mps = 900.0'),
            "segment[1]: changes the speed by 1,",
        ),
        (
            segments('kind = "turn", duration_s = 1e-3, angle_deg = 36_000.0'),
            "segment[1]: changes the yaw by 48,000,000 °/s",
        ),
        (
            segments('kind = "rest", duration_s = 1e-4, pitch_to_deg = 80.0'),
            "segment[1]: changes the pitch by 1,500,000 °/s",
        ),
        (
            segments(
                'kind = "cruise", duration_s = 150.0',
                place="[initial]\nspeed_mps = 900.0\n[place]\nlatitude_deg = 89.0\nlongitude_deg = 0.0\n",
            ),
            "latitude 89.9°",
        ),
        (
            segments(
                'kind = "reach-speed", duration_s = 10.0, to_mps = 900.0',
                'kind = "cruise", duration_s = 90.0, pitch_to_deg = -80.0',
            ),
            "the drive is at latitude",
        ),
        (fault("gnss-jamming"), "must say by how much gnss-jamming is off"),
        (fault("gnss-jaming"), "did you mean 'gnss-jamming'?"),
        (f'{STAND}[start]\nutc = "2031-01-01T00:00:00Z"\n', "no World Magnetic Model"),
    ],
)
def test_impossible_drives_and_faults_name_their_file(tmp_path: Path, text: str, words: str) -> None:
    file = tmp_path / "drive.toml"
    file.write_text(text)
    magnetometer = "1" if "Magnetic" in words else "0"
    command = ["simulate", str(file), "-o", str(tmp_path / "out.csv"), "-q", "--mag-rate", magnetometer]
    result = CliRunner().invoke(app, command)
    assert result.exit_code == 2, result.output
    assert words in result.stderr
    assert str(file) in result.stderr
    assert result.stderr.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["drive.toml"]


def test_faults_of_buses_are_left_out_and_told(tmp_path: Path) -> None:
    (tmp_path / "drive.toml").write_text(fault("spi-missing"))
    result = CliRunner().invoke(app, ["simulate", str(tmp_path / "drive.toml")])
    assert result.exit_code == 0, result.output
    assert "left out, as only boards have buses and chips: spi-missing gnss" in result.output
