"""What a killed run leaves behind: raw traffic and decoded rows up to the last second.

The oracle is the capture of the same run that was not killed: a run is the same bytes each time.
"""

import json
import os

import numpy as np
import pytest
from killed_runs import killed_at
from mcap.reader import make_reader
from replay_captures import FAULTS, captured
from typer.testing import CliRunner

from host.capture.overview import look_over
from host.capture.reader import CaptureReader, Decoded
from host.cli.main import app
from host.record.errors import UserError
from host.record.result import RunRequest
from host.recovery.repair import repair
from host.recovery.whole_reader import WholeReader
from host.replay.physical import replay_physical
from host.replay.request import ReplayRequest
from host.replay.strict import replay_strict

SECOND = 1_000_000_000
ROWS = ("/solution", "/gnss", "/bias", "/innovation", "/fix/solution", "/fix/gnss", "/event")
TIME_JUMPS = """fault=[
    {kind="gnss-time-jump",target="U3",at_s=30,duration_s=100,parameters={offset_s=2.0}},
    {kind="gnss-time-jump",target="U3",at_s=135,duration_s=50,parameters={offset_s=0.4}},
    {kind="cpu-reset",target="mcu",at_s=150}
]""".replace("\n", "")


def navtwin(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def request(out, *overrides, profile="full-rate", scenario="town-open"):
    return RunRequest("car_mems", scenario, profile, 1, overrides, out_dir=out)


def rows_of(reader):
    """Times and texts of each decoded topic; of events those that the board told."""
    found = {topic: [] for topic in ROWS}
    for message in reader.messages():
        if message.topic in found and (message.topic != "/event" or b'"source":"board"' in message.data):
            found[message.topic].append((message.time_ns, message.data))
    return found


@pytest.fixture(scope="module")
def killed(tmp_path_factory):
    """At 117.3 s, before anything but the board's start was decoded."""
    out = tmp_path_factory.mktemp("killed")
    return killed_at(117_300_000_000, request(out, "duration_s=170", FAULTS, profile="thesis"))


def test_after_kill_minus_nine_at_any_moment_less_than_a_second_is_missing(tmp_path):
    random = np.random.default_rng(20)
    for number, moment_ns in enumerate(random.integers(SECOND, 90 * SECOND, 4).tolist()):
        capture = killed_at(moment_ns, request(tmp_path / str(number), "duration_s=100"))
        overview = look_over(WholeReader(capture))
        assert 0.0 <= moment_ns / 1e9 - overview.recorded_s < 1.0
        assert any("did not reach its end" in finding for finding in overview.findings)
        replayed = replay_strict(ReplayRequest(capture))
        assert replayed.ok
        assert replayed.duration_s == overview.recorded_s


@pytest.mark.parametrize(
    ("profile", "fault", "moment_s"),
    [("thesis", FAULTS, 117.3), ("full-rate", TIME_JUMPS, 164.2)],
)
def test_rows_of_a_killed_run_are_those_of_the_whole_one_up_to_the_last_second(
    profile, fault, moment_s, tmp_path
):
    """With processor resets, a receiver that tells a wrong time, and every fault of a wire on the way."""
    whole = rows_of(CaptureReader(captured(profile, "duration_s=170", fault)[0]))
    capture = killed_at(
        round(moment_s * 1e9), request(tmp_path / "out", "duration_s=170", fault, profile=profile)
    )
    reader = WholeReader(capture)
    found = rows_of(reader)
    for topic in ROWS:
        assert found[topic] == whole[topic][: len(found[topic])], topic
        missing = [t_ns for t_ns, _text in whole[topic][len(found[topic]) :] if t_ns < (moment_s - 1.5) * 1e9]
        assert not missing, topic
    assert found["/solution"][-1][0] > (moment_s - 1.2) * 1e9
    assert reader.added["/solution"] > 0
    assert not reader.notes


def test_every_tool_gives_the_rows_of_a_killed_capture(killed, tmp_path):
    told = json.loads(navtwin("capture", "info", killed, "--json", "-").output)
    assert told["decoded_anew"]["/solution"] > 100
    assert {topic["topic"]: topic["last_s"] for topic in told["topics"]}["/solution"] > 116.1
    checked = navtwin("capture", "check", killed)
    assert checked.exit_code == 1
    assert "/solution ends at" not in checked.output
    assert navtwin("capture", "export", killed, "-f", "csv", "-o", tmp_path / "csv").exit_code == 0
    rows = (tmp_path / "csv" / "solution.csv").read_text().splitlines()
    assert float(rows[-1].split(",")[0]) > 116.1
    assert navtwin("capture", "cut", killed, "--from", 110, "-o", tmp_path / "end.mcap").exit_code == 0
    solutions = [
        r.time_ns for r in CaptureReader(tmp_path / "end.mcap") if getattr(r, "topic", "") == "/solution"
    ]
    assert len(solutions) > 29
    assert min(solutions) >= 110 * SECOND


def test_a_repaired_capture_opens_in_readers_that_need_an_index(killed, tmp_path):
    target = tmp_path / "whole.mcap"
    outcome = navtwin("capture", "repair", killed, "-o", target)
    assert outcome.exit_code == 0, outcome.output
    with target.open("rb") as file:
        reader = make_reader(file)
        times = [message.log_time for _s, _c, message in reader.iter_messages(["/solution"])]
        assert reader.get_summary().statistics.message_count > 1000
    assert times == sorted(times)
    assert times[-1] > 116.1 * SECOND
    replayed = replay_strict(ReplayRequest(target))
    assert replayed.ok
    assert replayed.duration_s == pytest.approx(117.0, abs=1.0)
    assert list(WholeReader(killed).messages()) == list(CaptureReader(target).messages())
    assert navtwin("capture", "repair", killed, "-o", target).exit_code == 2


def test_what_is_whole_is_not_repaired(tmp_path):
    with pytest.raises(UserError, match="it is whole"):
        repair(captured("thesis", "duration_s=12")[0], tmp_path / "x.mcap")
    assert not list(tmp_path.iterdir())


def test_physical_replay_of_a_killed_capture_has_a_road_to_its_end(tmp_path):
    capture = killed_at(100 * SECOND, request(tmp_path / "out", "duration_s=110"))
    result = replay_physical(ReplayRequest(capture))
    assert result.scored_against == "truth"
    assert result.result.duration_s > 99.0
    assert result.result.metrics["availability"] > 0.9


@pytest.mark.recording
@pytest.mark.skipif("NAVTWIN_DATA" not in os.environ, reason="needs real recordings")
def test_without_the_recording_rows_have_no_errors_and_that_is_told(tmp_path, monkeypatch):
    capture = killed_at(40 * SECOND, request(tmp_path / "out", scenario="real-drive", profile=None))
    with_truth = rows_of(WholeReader(capture))
    monkeypatch.delenv("NAVTWIN_DATA")
    reader = WholeReader(capture)
    last = [record.value for record in reader if isinstance(record, Decoded) and record.topic == "/gnss"][-1]
    known = json.loads(with_truth["/gnss"][-1][1])
    assert last["t_s"] == pytest.approx(known["t_s"], abs=0.2)  # as the board dated it
    changed = {name for name in known if known[name] != last[name]} - {"t_s"}
    assert changed == {name for name in known if "error" in name}
    assert last["error_north_m"] is None
    assert "NAVTWIN_DATA" in reader.notes[0]


@pytest.mark.soak
def test_twenty_runs_killed_at_random_moments(tmp_path):
    whole = rows_of(CaptureReader(captured("full-rate", "duration_s=400", TIME_JUMPS)[0]))
    for number, moment_ns in enumerate(np.random.default_rng(6).integers(SECOND, 399 * SECOND, 20).tolist()):
        capture = killed_at(moment_ns, request(tmp_path / str(number), "duration_s=400", TIME_JUMPS))
        reader = WholeReader(capture)
        found = rows_of(reader)
        recorded_s = look_over(CaptureReader(capture)).recorded_s
        assert moment_ns / 1e9 - recorded_s < 1.0
        for topic in ROWS:
            assert found[topic] == whole[topic][: len(found[topic])], topic
        assert recorded_s < 3.0 or recorded_s - found["/solution"][-1][0] / 1e9 < 0.5
