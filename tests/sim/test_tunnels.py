"""Outages by place: where the truth is inside a polygon there is no fix, and nowhere else."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from typer.testing import CliRunner

from host.cli.main import app
from host.sim.scenario.load import load_scenario
from host.sim.world import World

NS = 1_000_000_000
LOOP = """
duration_s = 400.0
segment = [
  { kind = "reach-speed", duration_s = 10.0, to_mps = 20.0 },
  { kind = "circle", duration_s = 390.0, rate_dps = 2.0 },
]
[place]
latitude_deg = 47.0
longitude_deg = %r
[gnss]
reacquisition_s = 0.0
"""
TUNNEL = """
[[tunnel]]
polygon = %s
"""
STAR = [(0.001, -0.004), (0.002, 0.02), (-0.006, 0.01), (-0.003, 0.004), (-0.009, -0.002)]
"""Corners from the start, °; not convex."""


def corners(longitude: float) -> list[list[float]]:
    return [[47.0 + north, (longitude + east + 180.0) % 360.0 - 180.0] for north, east in STAR]


def circled(places: NDArray[np.float64], outline: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Seen from inside, the corners go once around: the angles between them add up to ±2π, else to 0."""
    sights = outline[None] - places[:, None]
    after = np.roll(sights, -1, axis=1)
    cross = sights[..., 0] * after[..., 1] - sights[..., 1] * after[..., 0]
    turns = np.arctan2(cross, (sights * after).sum(axis=2)).sum(axis=1)
    found: NDArray[np.bool_] = np.abs(turns) > np.pi
    return found


def loop(folder: Path, longitude: float, more: str = "") -> World:
    path = folder / "loop.toml"
    path.write_text(LOOP % longitude + more)
    return World(load_scenario(path))


@pytest.mark.parametrize("longitude", [8.0, 179.999, -179.999])
def test_windows_are_the_truth_is_inside(tmp_path: Path, longitude: float) -> None:
    world = loop(tmp_path, longitude, TUNNEL % corners(longitude))
    times = np.arange(0, 400 * NS, NS // 20)
    truth = world.truth(times)
    east = (np.degrees(truth.longitude) - longitude + 180.0) % 360.0 - 180.0
    places = np.column_stack((np.degrees(truth.latitude) - 47.0, east))
    covered = circled(places, np.array(STAR))
    told = np.zeros(len(times), dtype=bool)
    for window in world.outages:
        told |= (times >= window.start_ns) & (times < window.end_ns)
    assert len(world.outages) >= 3
    off = np.flatnonzero(told != covered)
    edges = times[np.flatnonzero(np.diff(covered)) + 1]
    assert all(np.min(np.abs(edges - times[k])) <= NS // 10 for k in off)
    receiver = world.gnss("U3")
    fixes = np.array([receiver.epoch(int(t)).fix for t in times[::20]])
    np.testing.assert_array_equal(fixes, ~told[::20])


def test_tunnels_and_outages_that_meet_are_one(tmp_path: Path) -> None:
    by_place = loop(tmp_path, 8.0, TUNNEL % corners(8.0)).outages
    first = by_place[1]
    overlapping = f"\n[[outage]]\nstart_s = {first.start_ns / NS - 2.0}\nduration_s = 5.0\n"
    joined = loop(tmp_path, 8.0, TUNNEL % corners(8.0) + overlapping).outages
    assert len(joined) == len(by_place)
    assert joined[1].start_ns == first.start_ns - 2 * NS
    assert joined[1].end_ns == first.end_ns
    far = [[lat + 1.0, lon] for lat, lon in corners(8.0)]
    assert loop(tmp_path, 8.0, TUNNEL % far).outages == ()
    around = [[46.0, 7.0], [48.0, 7.0], [48.0, 9.0], [46.0, 9.0]]
    (whole,) = loop(tmp_path, 8.0, TUNNEL % around).outages
    assert (whole.start_ns, whole.end_ns) == (0, 400 * NS)


@pytest.mark.parametrize(
    ("polygon", "words"),
    [
        ([[47.0, 8.0], [47.1, 8.0]], "polygon"),
        ([[47.0, 8.0], [47.1, 8.0], [95.0, 8.0]], "[95, 8]"),
        ([[47.0, 8.0], [47.1, 8.0], [47.0, 200.0]], "[47, 200]"),
        ([[47.0, 8.0], [47.1, 8.0], [47.0]], "polygon"),
        ([[47.0, 8.0], [47.1, 8.0], [47.0, 120.0]], "of longitude wide"),
        ('"a"', "polygon"),
    ],
)
def test_mistakes_are_told_in_one_message(tmp_path: Path, polygon: object, words: str) -> None:
    path = tmp_path / "bad.toml"
    path.write_text(LOOP % 8.0 + TUNNEL % polygon)
    result = CliRunner().invoke(app, ["simulate", str(path)])
    assert result.exit_code == 2, result.output
    assert words in result.output
    assert "Traceback" not in result.output
