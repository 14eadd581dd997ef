"""A run's folder: what is in it, what is not touched, what an unfinished run leaves."""

import json

import numpy as np
import pytest
import synthetic_run

from host.capture.reader import CaptureReader, Decoded
from host.record.atomic import write_whole
from host.record.errors import UserError
from host.record.recorder import Recorder
from host.record.result import RunResult


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("runs") / "first"
    synthetic_run.run(path)
    return path


def test_a_finished_run_leaves_these_files(folder):
    names = sorted(path.name for path in folder.iterdir())
    assert names == ["manifest.json", "report.html", "result.json", "run.mcap", "solution.csv"]


def test_the_manifest_tells_what_ran(folder):
    manifest = json.loads((folder / "manifest.json").read_text())
    assert manifest["status"] == "complete"
    assert manifest["seed"] == 3
    assert manifest["overrides"] == ["gnss.latency_s=0.1"]
    assert manifest["scenario_text"].startswith('name = "town"')
    assert manifest["state_hash"] == "5e1f" * 16
    assert set(manifest["versions"]) >= {"python", "navtwin", "numpy", "numba"}


def test_the_result_has_the_stable_keys(folder):
    document = json.loads((folder / "result.json").read_text())
    assert set(document) >= {
        *("board", "scenario", "profile", "seed", "duration_s", "wall_s", "real_time_factor", "state_hash"),
        *("metrics", "gnss", "outages", "cpu", "buses", "faults", "expectations", "events"),
    }
    for quantity, unit in (
        ("position_horizontal", "m"),
        ("velocity", "mps"),
        ("roll", "deg"),
        ("yaw", "deg"),
    ):
        for figure in ("rms", "max", "p95"):
            assert document["metrics"][f"{quantity}_{figure}_{unit}"] > 0
    assert set(document["outages"][0]) >= {"start_s", "duration_s", "horizontal_drift_m"}
    assert set(document["cpu"][0]) >= {"name", "load", "deadline_misses", "tasks"}
    assert set(document["faults"][0]) >= {"name", "at_s", "fired"}
    assert set(document["expectations"][0]) >= {"name", "value", "limit", "ok"}
    assert document["real_time_factor"] == pytest.approx(600)


def test_numbers_that_json_lacks_are_null():
    result = RunResult("b", "s", "p", 1, 1.0, 0.0, "", {"a": float("nan"), "b": None, "c": 1.5}, {})
    document = json.loads(json.dumps(result.to_dict(), allow_nan=False))
    assert document["metrics"] == {"a": None, "b": None, "c": 1.5}
    assert document["real_time_factor"] is None


def test_the_csv_holds_every_solution(folder):
    table = np.genfromtxt(folder / "solution.csv", delimiter=",", names=True)
    assert len(table) == 2400
    assert table["t_s"][-1] == pytest.approx(239.9)
    assert table["latitude_deg"][0] == pytest.approx(47.3, abs=1e-4)
    rms = np.sqrt(np.mean(table["error_north_m"] ** 2 + table["error_east_m"] ** 2))
    assert 0.3 < rms < 5


def test_the_capture_holds_the_decoded_topics(folder):
    reader = CaptureReader(folder / "run.mcap")
    topics = [record.topic for record in reader if isinstance(record, Decoded)]
    counts = {topic: topics.count(topic) for topic in set(topics)}
    tables = {"/solution": 1200, "/gnss": 240, "/innovation": 209, "/bias": 240, "/event": 1}
    assert counts == tables | {"/fix/gnss": 209, "/fix/solution": 228}
    assert reader.summary["state_hash"] == "5e1f" * 16


def test_two_equal_runs_leave_equal_bytes(folder, tmp_path):
    synthetic_run.run(tmp_path / "second")
    for name in ("manifest.json", "report.html", "run.mcap", "solution.csv"):
        assert (folder / name).read_bytes() == (tmp_path / "second" / name).read_bytes(), name


def test_a_second_run_replaces_the_first_one(tmp_path):
    synthetic_run.run(tmp_path / "run")
    synthetic_run.run(tmp_path / "run", capture=False)
    assert not (tmp_path / "run" / "run.mcap").exists()


def test_an_interrupted_run_is_marked_and_readable(tmp_path):
    def interrupted():
        with Recorder(synthetic_run.manifest(), tmp_path / "run") as recorder:
            synthetic_run.feed(recorder)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    names = sorted(path.name for path in (tmp_path / "run").iterdir())
    assert names == ["manifest.json", "run.mcap.part", "solution.csv.part"]
    assert json.loads((tmp_path / "run" / "manifest.json").read_text())["status"] == "interrupted by the user"
    assert len(list(CaptureReader(tmp_path / "run" / "run.mcap.part"))) > 2400
    assert len((tmp_path / "run" / "solution.csv.part").read_text().splitlines()) == 2401


def test_a_failed_run_says_why(tmp_path):
    with pytest.raises(RuntimeError), Recorder(synthetic_run.manifest(), tmp_path / "run"):
        raise RuntimeError("the filter fell over")
    status = json.loads((tmp_path / "run" / "manifest.json").read_text())["status"]
    assert status == "failed: the filter fell over"


@pytest.mark.parametrize(
    "content", [{"thesis.tex": "x"}, {"manifest.json": '{"name": "my web app"}'}, {"manifest.json": "[]"}]
)
def test_a_folder_of_somebody_else_is_not_touched(tmp_path, content):
    for name, text in content.items():
        (tmp_path / name).write_text(text)
    with pytest.raises(UserError, match="does not hold a navtwin run; name a new folder"):
        Recorder(synthetic_run.manifest(), tmp_path)
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == content


def test_an_empty_folder_and_a_new_one_below_it_are_used(tmp_path):
    Recorder(synthetic_run.manifest(), tmp_path).__exit__(None, None, None)
    Recorder(synthetic_run.manifest(), tmp_path / "a" / "b").__exit__(None, None, None)


def test_a_file_or_a_place_below_a_file_is_no_folder(tmp_path):
    (tmp_path / "x").write_text("")
    with pytest.raises(UserError, match=r"--out .*x: is a file; name a folder"):
        Recorder(synthetic_run.manifest(), tmp_path / "x")
    with pytest.raises(UserError, match=r"--out .*x/y: cannot be (read|written): Not a directory"):
        Recorder(synthetic_run.manifest(), tmp_path / "x" / "y")


def test_a_file_is_written_whole_or_not_at_all(tmp_path):
    with pytest.raises(UserError, match=r"--json .*nowhere/out\.json: cannot be written: No such file"):
        write_whole(tmp_path / "nowhere" / "out.json", "{}", "--json")
    (tmp_path / "folder").mkdir()
    with pytest.raises(UserError, match=r"folder: cannot be written: Is a directory"):
        write_whole(tmp_path / "folder", "{}")
    assert [path.name for path in tmp_path.iterdir()] == ["folder"]


def test_events_are_bounded():
    with Recorder(synthetic_run.manifest(), None) as recorder:
        for tick in range(1500):
            recorder.add_event(tick * 1_000_000, "gnss", f"event {tick}")
        result = recorder.finish(duration_s=2.0, wall_s=1.0, state_hash="")
    assert len(result.events) == 1001
    assert result.events[-1].text == "500 more events are not listed"
