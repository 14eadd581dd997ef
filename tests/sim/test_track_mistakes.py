"""Trajectories that cannot be: one message, and nothing is written. Odd ones that can be are taken."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from host.cli.main import app

HEAD = "t_s,lat,lon,alt"
ROW: list[tuple[str, Any]] = [
    *((name, "f8") for name in ("latitude", "longitude", "height", "yaw", "pitch", "roll")),
    ("t_ns", "i8"),
]


def table(head: str, *columns: str, points: int = 8) -> bytes:
    """Rows of `columns`, in which {k} is the number of the point."""
    rows = [",".join(columns).replace("{k}", str(k)) for k in range(points)]
    return "\n".join([head, *rows, ""]).encode()


def archive(rows: np.ndarray[Any, Any]) -> bytes:
    buffer = io.BytesIO()
    np.savez(buffer, imu=rows)
    return buffer.getvalue()


def inverse(folder: Path, name: str, content: bytes, *more: str) -> Result:
    (folder / name).write_bytes(content)
    return CliRunner().invoke(app, ["inverse", str(folder / name), "-o", str(folder / "out.csv"), *more])


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        (
            "a.csv",
            table(f"{HEAD},vn,ve,vd", "{k}", "47", "8", "5", "100", "0", "0"),
            "line 3: the velocities lead 100 m",
        ),
        (
            "a.csv",
            table(f"{HEAD},vn,ve,vd", "{k}", "47", "8", "5", "1e9", "0", "0"),
            "line 2: velocity 1,000,000,000 m/s",
        ),
        (
            "a.csv",
            table(f"{HEAD},yaw,pitch,roll", "{k}", "47", "8", "5", "1e300", "0", "0"),
            "line 2: yaw 1e+300°",
        ),
        (
            "a.csv",
            table(f"{HEAD},yaw,pitch,roll", "{k}", "47", "8", "5", "0", "91", "0"),
            "line 2: pitch 91°",
        ),
        ("a.csv", table(HEAD, "{k}", "47", "400", "5"), "line 2: longitude 400°"),
        ("a.csv", table(HEAD, "{k},5", "47,05", "8", "5"), "line 2: 6 values, the header has 4"),
        (
            "a.csv",
            table(HEAD, "0001-01-01T00:00:0{k}Z", "47", "8", "5"),
            "line 2: the date lies outside of 1980",
        ),
        ("a.csv", f"{HEAD}\n0,47,8,{'1' * 200_000}\n".encode(), "larger than field limit"),
        (
            "a.nmea",
            b"$GPGGA,080000.00,4799.0,N,00800.000,E,1,08,1.0,400.0,M,47.0,M,,*61\r\n",
            "line 1: GGA that cannot",
        ),
        (
            "a.nmea",
            b"$GPGGA,080000.00,4700.0,X,00800.000,E,1,08,1.0,400.0,M,47.0,M,,*77\r\n",
            "line 1: GGA that cannot",
        ),
        (
            "a.nmea",
            b"$GPGGA,240000.00,4700.0,N,00800.000,E,1,08,1.0,400.0,M,47.0,M,,*6F\r\n",
            "line 1: GGA that cannot",
        ),
        ("a.csv", table(HEAD, "inf", "47", "8", "5"), "line 2: the time is"),
        ("a.gpx", b'<?xml version="1.0" encoding="martian"?><gpx/>', "unknown encoding: martian"),
        ("a.kml", b'<?xml version="1.0" encoding="utf-7"?><kml/>', "is not valid XML: multi-byte encodings"),
        ("a.npz", b"", "is not what navtwin simulate writes"),
        ("a.npz", archive(np.zeros(9, dtype=[*ROW, ("velocity", "f8")])), "into shape (9,3)"),
        (
            "a.npz",
            archive(np.zeros(9, dtype=[("t_ns", "U3"), *ROW[:6], ("velocity", "f8", 3)])),
            "is not what",
        ),
    ],
    ids=lambda value: None if isinstance(value, bytes) else str(value)[:40],
)
def test_what_cannot_be_is_one_message(tmp_path: Path, name: str, content: bytes, words: str) -> None:
    result = inverse(tmp_path, name, content)
    assert result.exit_code == 2, result.output
    assert words in result.stderr
    assert name in result.stderr
    assert result.stderr.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == [name]


@pytest.mark.parametrize("points", [4, 5, 6])
def test_few_points_are_enough(tmp_path: Path, points: int) -> None:
    """A second apart and 1e-4° north each: 11.1 m/s by the meridian's radius."""
    content = table(HEAD, "{k}", "47.000{k}", "8", "5", points=points)
    result = inverse(tmp_path, "a.csv", content, "--json", "-", "-q")
    assert result.exit_code == 0, result.output
    told = json.loads(result.stdout)
    assert (told["points"], told["samples"]) == (points, 200 * (points - 1))
    assert told["fastest_mps"] == pytest.approx(11.12, abs=0.02)


def test_a_line_over_the_date_line_is_no_way_round_the_earth(tmp_path: Path) -> None:
    places = b" ".join(b"%.4f,10,5" % east for east in (179.998, 179.999, 180.0, -179.999, -179.998))
    content = b"<kml><LineString><coordinates>" + places + b"</coordinates></LineString></kml>"
    result = inverse(tmp_path, "a.kml", content, "--speed", "10", "--json", "-", "-q")
    assert result.exit_code == 0, result.output
    assert json.loads(result.stdout)["duration_s"] == pytest.approx(4 * 109.64 / 10.0, abs=0.1)


@pytest.mark.parametrize("unit", ["t_s", "t_ns"])
def test_times_from_1970_lose_no_digit(tmp_path: Path, unit: str) -> None:
    """200 points a second at 300 m/s straight on: the quarter of a microsecond that a float64 of such a time
    leaves out would be some m/s² of force."""
    texts = [f"{1_715_673_600_000_000_000 + 5_000_000 * k}" for k in range(400)]
    if unit == "t_s":
        texts = [f"{text[:-9]}.{text[-9:]}" for text in texts]
    rows = [f"{text},10,{8 + 1e-5 * k:.9f},1000" for k, text in enumerate(texts)]
    (tmp_path / "a.csv").write_text(f"{unit},lat,lon,alt\n" + "\n".join(rows) + "\n")
    made = tmp_path / "a.npz"
    result = CliRunner().invoke(app, ["inverse", str(tmp_path / "a.csv"), "-o", str(made), "-q"])
    assert result.exit_code == 0, result.output
    force = np.load(made)["imu"]["dv"] / 5e-3
    assert np.ptp(force[100:-100, 0]) < 0.05
