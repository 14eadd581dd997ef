"""`navtwin compare`: the lanes are the board, growth and goals are told, wrong words get one message."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from firmware.nav.attitude import layout as at
from host.capture.blocks import SpiTransaction
from host.capture.reader import CaptureReader
from host.cli.main import app
from host.compare.lanes import Lane
from host.compare.source import from_capture
from host.compare.word_stream import bursts_of

RUN = ("run", "uav_ahrs", "--scenario", "flight", "--set", "duration_s=22", "-q")


def navtwin(*arguments: object) -> Result:
    return CliRunner().invoke(app, list(map(str, arguments)))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """22 s of flight without drift compensation: rest, then the take-off run."""
    made = tmp_path_factory.mktemp("compare") / "run"
    result = navtwin(*RUN, "--profile", "float32", "--set", "profile.drift_compensation=false", "--out", made)
    assert result.exit_code in (0, 1), result.output
    return made


@pytest.fixture(scope="module")
def told(folder: Path) -> dict[str, Any]:
    result = navtwin("compare", "--capture", folder, "--json", "-", "-q", "--no-cycles")
    assert result.exit_code == 0, result.output
    found: dict[str, Any] = json.loads(result.stdout)
    return found


def test_all_bursts_of_a_capture_come_as_they_were(folder: Path) -> None:
    """A second way through the file, record by record."""
    expected = [
        (one.start_ns, one.miso)
        for one in CaptureReader(folder / "run.mcap")
        if isinstance(one, SpiTransaction) and one.mosi == bytes((0x42, *[0] * 29))
    ]
    found = [
        (int(time_ns), raw.tobytes())
        for some in bursts_of(folder / "run.mcap")
        for time_ns, raw in zip(some.times_ns, some.raw, strict=True)
    ]
    assert found == expected
    assert len(found) > 20 * 250


def test_a_lane_is_the_board(folder: Path) -> None:
    """What the board said over its link is what the lane of its arithmetic makes of the captured words."""
    source = from_capture(folder)
    lane = Lane("float32", source.config)
    records = {}
    for some in bursts_of(source.capture):
        made = lane.take(some)
        for place in np.flatnonzero(made.made):
            record = made.records[place]
            angles = record[[at.OUT_YAW, at.OUT_PITCH, at.OUT_ROLL]] * 1e-9
            records[tuple(np.round(np.degrees(angles), 4).tolist())] = record
    with (folder / "solution.csv").open(encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if float(row["mode"]) >= 3]
    assert len(rows) > 300
    matched = 0
    for row in rows:
        angles = tuple(float(row[name]) for name in ("yaw_deg", "pitch_deg", "roll_deg"))
        if angles in records:
            record = records[angles]
            assert record[at.OUT_VELOCITY] * 1e-6 == pytest.approx(float(row["v_north_mps"]), abs=6e-5)
            assert record[at.OUT_LATITUDE] * 1e-9 == pytest.approx(float(row["latitude_deg"]), abs=2e-9)
            matched += 1
    assert matched == len(rows)


def test_fixed_and_float32_stay_near_float64(told: dict[str, Any]) -> None:
    assert told["reference"] == "float64"
    assert told["met"] is True
    assert told["drift_compensation"] is False
    fixed, float32 = told["arithmetics"]["fixed"], told["arithmetics"]["float32"]
    assert fixed["iterations"] == float32["iterations"] == told["iterations"]["float64"] > 15 * 125
    assert 0.0 < fixed["rms"]["attitude"] < 1e-4
    assert 0.0 < float32["rms"]["attitude"] < 0.01
    assert fixed["made_by_one_only"] == 0
    assert not any(sum(kinds.values()) for kinds in told["saturations"].values())


def test_first_divergence_and_growth_are_told(told: dict[str, Any]) -> None:
    for one in told["arithmetics"].values():
        first = one["first"]["attitude"]
        assert told["begin_s"] < first["t_s"] < told["begin_s"] + 8.0
        assert 0.0 < first["amount"] <= one["largest"]["attitude"]
        since = [state["since_s"] for state in one["growth"]]
        assert since[:3] == [1, 3, 10]
        assert since == sorted(since)
        assert one["growth"][-1]["rms"] == one["rms"]
        assert one["growth"][-1]["difference"] == one["at_end"]
        largest = [state["largest"]["position"] for state in one["growth"]]
        assert largest == sorted(largest)


def test_reference_is_the_last_one_named_without_float64(folder: Path) -> None:
    result = navtwin(
        "compare", "--capture", folder, "-p", "float32,fixed", "--json", "-", "-q", "--no-cycles"
    )
    found = json.loads(result.stdout)
    assert found["reference"] == "fixed"
    assert list(found["arithmetics"]) == ["float32"]
    assert found["met"] is None
    assert result.exit_code == 0


def test_a_scenario_gives_what_its_capture_gives(folder: Path, told: dict[str, Any], tmp_path: Path) -> None:
    out = tmp_path / "found"
    result = navtwin(
        *(
            "compare",
            "uav_ahrs",
            "-p",
            "fixed,float32,float64",
            "--scenario",
            "flight",
            "--set",
            "duration_s=22",
        ),
        *("--set", "profile.drift_compensation=false", "--out", out, "--no-cycles"),
    )
    assert result.exit_code == 0, result.output
    assert "First divergence" in result.output
    found = json.loads((out / "compare.json").read_text())
    assert found["arithmetics"] == told["arithmetics"]
    page = (out / "report.html").read_text()
    assert 'id="growth"' in page
    assert sorted(path.name for path in out.iterdir()) == ["compare.json", "report.html"]


def test_a_capture_that_was_cut_off_is_compared_as_far_as_it_goes(folder: Path, tmp_path: Path) -> None:
    whole = (folder / "run.mcap").read_bytes()
    part = tmp_path / "run.mcap"
    part.write_bytes(whole[: len(whole) * 3 // 4])
    result = navtwin("compare", "--capture", part, "-p", "fixed,float64", "--json", "-", "-q", "--no-cycles")
    assert result.exit_code == 0, result.output
    assert json.loads(result.stdout)["bursts"] > 1_000


@pytest.mark.soak
def test_cycles_come_with_a_comparison(folder: Path) -> None:
    result = navtwin("compare", "--capture", folder, "-p", "fixed,float32")
    assert result.exit_code == 0, result.output
    assert "document's solution" in result.output
    assert "52,500" in result.output


WRONG = (
    (("--profiles", "fixed"), "nothing to compare with"),
    (("--profiles", "fixed,float46"), "'float46' is not possible"),
    (("--capture", "/nowhere/run.mcap"), "/nowhere/run.mcap"),
    (("--capture", "x.mcap", "--scenario", "flight"), "leave out --scenario"),
    (("car_mems", "--set", "duration_s=1"), "one arithmetic"),
    (("uav_ahrs", "--scenario", "flihgt"), "did you mean 'flight'"),
    (("uav_ahrs", "--set", "duration_s=3"), "the alignment never ended"),
)


@pytest.mark.parametrize(("arguments", "message"), WRONG)
def test_wrong_words_get_one_message(arguments: tuple[str, ...], message: str) -> None:
    result = navtwin("compare", *arguments)
    assert result.exit_code == 2, result.output
    assert message in result.output
    assert "Traceback" not in result.output


def test_a_folder_in_use_is_refused_before_the_work(tmp_path: Path) -> None:
    (tmp_path / "kept").write_text("mine")
    result = navtwin("compare", "--out", tmp_path)
    assert result.exit_code == 2
    assert "exists already" in result.output
    assert (tmp_path / "kept").read_text() == "mine"
