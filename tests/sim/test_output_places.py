"""What the simulator's commands write never takes the place of what they read, nor of a device."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest
from typer.testing import CliRunner

from host.cli.main import app
from host.record.atomic import made_aside, write_whole
from host.record.errors import UserError

DRIVE = """
segment = [{ kind = "rest", duration_s = 4.0 }]
place = { latitude_deg = 47.0, longitude_deg = 8.0 }
"""
TRACK = "t_s,lat,lon,alt\n" + "".join(f"{k},{47 + k * 1e-4},8.0,400\n" for k in range(6))


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "drive.toml").write_text(DRIVE)
    (tmp_path / "ride.truth.csv").write_text(TRACK)
    (tmp_path / "track.csv").write_text(TRACK)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    "command",
    [
        "simulate ./drive.toml -o drive.toml --format csv",
        "simulate ./drive.toml -o x.csv --json ./drive.toml",
        "simulate ./drive.toml -o x.csv --json ./x.csv",
        "inverse track.csv -o ./track.csv",
        "inverse ride.truth.csv -o ride.csv --format pyins",
        "inverse track.csv -o x.npz --json track.csv",
        "allan track.csv -o track.csv",
        "evaluate ./drive.toml -o drive.toml",
    ],
)
def test_what_is_read_and_what_is_written_stay_apart(folder: Path, command: str) -> None:
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    result = CliRunner().invoke(app, command.split())
    assert result.exit_code == 2, result.output
    assert result.stderr.count("\n") == 1
    assert "name another one" in result.stderr
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


@pytest.mark.parametrize("command", ["simulate ./drive.toml -f csv -o", "simulate ./drive.toml --json"])
def test_a_pipe_stays_one(folder: Path, command: str) -> None:
    """As would a device: renaming a file there would take its place."""
    pipe = folder / "pipe"
    os.mkfifo(pipe)
    result = CliRunner().invoke(app, [*command.split(), "pipe"])
    assert result.exit_code == 2, result.output
    assert "is a device or pipe, no file" in result.stderr
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    assert sorted(path.name for path in folder.iterdir()) == [
        "drive.toml",
        "pipe",
        "ride.truth.csv",
        "track.csv",
    ]


def test_nothing_else_that_is_written_whole_replaces_one(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    with pytest.raises(UserError, match=r"^--html .*pipe: is a device or pipe"):
        write_whole(pipe, "text", "--html")
    with pytest.raises(UserError, match="is a device or pipe"), made_aside(pipe, "-o") as part:
        part.write_text("text")
    assert stat.S_ISFIFO(pipe.stat().st_mode)
