"""The command line as people and CI use it, with a recorded synthetic run behind it."""

import json
import os
import signal
import subprocess
import sys
import time
import types
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import pytest
import synthetic_run
from typer.testing import CliRunner

from boards.validation import DescriptionError
from host.cli.main import app
from host.record.errors import UserError
from host.sim.scenario.errors import ScenarioError

ROOT = Path(__file__).parents[2]


@pytest.fixture
def board_runs(monkeypatch):
    """Puts a runner in place that does what it is told; returns the requests it was given."""
    requests = []
    behaviour = {"expect": synthetic_run.EXPECT, "raises": None}

    def run(request):
        requests.append(request)
        if behaviour["raises"] is not None:
            raise behaviour["raises"]
        if request.progress is not None:
            request.progress(240.0, 240.0)
        result = synthetic_run.run(request.out_dir, request.capture, behaviour["expect"])
        return replace(result, seed=request.seed)

    module = types.ModuleType("host.run.runner")
    module.run = run
    monkeypatch.setitem(sys.modules, "host.run.runner", module)
    behaviour["requests"] = requests
    return behaviour


@pytest.fixture
def navtwin(tmp_path, monkeypatch):
    """Calls the command line in an empty folder."""
    monkeypatch.chdir(tmp_path)
    runner = CliRunner()
    return lambda *arguments: runner.invoke(app, [str(argument) for argument in arguments])


def test_help_is_quick_teaches_by_example_and_tells_exit_codes():
    command = [sys.executable, "-m", "host.cli.main", "--help"]
    began = time.perf_counter()
    help_text = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert time.perf_counter() - began < 2.0
    assert "navtwin run car_mems --scenario outages --seed 7  another one, other noise" in help_text
    assert "0: expectations met, 1: not met, 2: bad input" in help_text


def test_help_imports_nothing_heavy():
    heavy = ("numpy", "numba", "plotly", "mcap", "rich", "boards", "hal")  # typer itself brings pydantic
    script = (
        "import sys, contextlib, io\n"
        "from host.cli.main import app\n"
        "with contextlib.suppress(SystemExit), contextlib.redirect_stdout(io.StringIO()):\n"
        "    app(['run', '--help'])\n"
        f"print([name for name in {heavy} if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_version(navtwin):
    assert navtwin("--version").output.startswith("navtwin 0.")


def test_boards_as_table_and_as_json(navtwin):
    shown = navtwin("boards")
    assert shown.exit_code == 0
    for word in ("car_mems", "STM32F405, 168 MHz", "BMI160", "NEO-M8N", "thesis", "full-rate"):
        assert word in shown.output
    (board,) = [
        board for board in json.loads(navtwin("boards", "--json").output) if board["name"] == "car_mems"
    ]
    assert board["default_profile"] == "full-rate"
    assert {"refdes": "U2", "part": "BMI160"} in board["chips"]
    assert "town-open" in [scenario["name"] for scenario in board["scenarios"]]


def test_a_run_that_misses_an_expectation_ends_with_1_and_shows_its_tables(navtwin, board_runs, tmp_path):
    done = navtwin("run", "car_mems", "--scenario", "town", "--seed", 3, "--out", "first")
    assert done.exit_code == 1
    assert "1 of 4 expectations NOT MET (240 s in 0.4 s, 600 × real time)" in done.output
    for title in ("Expectations", "Errors against the truth", "GNSS outages", "Tasks", "Buses", "Faults"):
        assert title in done.output
    assert (tmp_path / "first" / "report.html").is_file()
    assert "report: first/report.html" in done.output


def test_a_run_that_meets_all_ends_with_0(navtwin, board_runs):
    board_runs["expect"] = {"availability": synthetic_run.Limit(">=", 0.9)}
    done = navtwin("run", "car_mems", "--quiet")
    assert done.exit_code == 0
    assert len(done.output.splitlines()) == 2
    assert "the expectation is met" in done.output


def test_what_was_asked_reaches_the_runner(navtwin, board_runs, tmp_path):
    options = ("-s", "outages", "-p", "thesis", "--seed", 7, "--set", "gnss.latency_s=0.1", "--set", "a.b=2")
    navtwin("run", "car_mems", *options, "--data", tmp_path, "--no-capture", "-q")
    (request,) = board_runs["requests"]
    assert (request.board, request.scenario, request.profile, request.seed) == (
        "car_mems",
        "outages",
        "thesis",
        7,
    )
    assert request.overrides == ("gnss.latency_s=0.1", "a.b=2")
    assert request.data_dir == tmp_path
    assert request.capture is False
    assert str(request.out_dir) == "runs/car_mems-outages-thesis-7"


def test_the_default_folder_names_what_the_board_runs_by_itself(navtwin, board_runs):
    navtwin("run", "car_mems", "-q")
    assert str(board_runs["requests"][0].out_dir) == "runs/car_mems-town-full-rate-1"
    navtwin("run", "car_mems", "-q", "-s", "drives/My Drive.toml")
    assert str(board_runs["requests"][1].out_dir) == "runs/car_mems-My Drive-full-rate-1"


def test_json_on_standard_output_is_nothing_but_json(navtwin, board_runs):
    done = navtwin("run", "car_mems", "--json", "-")
    document = json.loads(done.stdout)
    assert document["board"] == "car_mems"
    assert document["ok"] is False
    assert "Errors against the truth" in done.stderr


def test_json_and_junit_files(navtwin, board_runs, tmp_path):
    navtwin("run", "car_mems", "--seed", 3, "--json", "out.json", "--junit", "out.xml", "-q")
    assert json.loads((tmp_path / "out.json").read_text())["seed"] == 3
    suite = ElementTree.parse(tmp_path / "out.xml").getroot().find("testsuite")
    assert (suite.get("tests"), suite.get("failures")) == ("4", "1")
    cases = suite.findall("testcase")
    assert cases[0].get("name") == "position_horizontal_rms_m <= gnss.position_horizontal_rms_m"
    (failed,) = [case for case in cases if case.find("failure") is not None]
    assert failed.get("name") == "yaw_rms_deg <= 0.05"
    assert "yaw_rms_deg is 0.2" in failed.find("failure").get("message")
    assert not list(tmp_path.glob("*.part"))


@pytest.mark.parametrize(
    "error",
    [
        UserError("--profile thesys: car_mems has no such profile; did you mean 'thesis'?"),
        DescriptionError("board.toml: unknown key 'clock'; did you mean 'clock_hz'?"),
        ScenarioError("town.toml: duration_s = -3: must be greater than 0; for example: duration_s = 1200.0"),
    ],
)
def test_a_users_mistake_is_one_line_and_ends_with_2(navtwin, board_runs, error):
    board_runs["raises"] = error
    done = navtwin("run", "car_mems")
    assert done.exit_code == 2
    assert done.stderr == f"navtwin: {error}\n"
    assert done.stdout == ""


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nosuch"], "no board 'nosuch'"),
        (["car_mems", "--data", "nowhere"], "--data nowhere: no such folder; for example"),
        (
            ["car_mems", "--json", "nowhere/x.json"],
            "--json nowhere/x.json: the folder nowhere does not exist",
        ),
        (["car_mems", "--junit", "."], "--junit .: is a folder; name a file"),
        (["car_mems", "--out", "notes"], "--out notes: the folder exists and does not hold a navtwin run"),
        (["car_mems", "--out", "notes/todo.txt"], "--out notes/todo.txt: is a file; name a folder"),
        (["car_mems", "--seed", "x"], "'--seed'"),
        (["car_mems", "--sed", "1"], "No such option: --sed"),
        ([], "Missing argument"),
    ],
)
def test_bad_input_ends_with_2_and_says_what(navtwin, board_runs, tmp_path, arguments, message):
    (tmp_path / "notes").mkdir()
    (tmp_path / "notes" / "todo.txt").write_text("milk")
    done = navtwin("run", *arguments)
    assert done.exit_code == 2
    assert message in done.stderr
    assert "Traceback" not in done.output
    assert (tmp_path / "notes" / "todo.txt").read_text() == "milk"


def test_ctrl_c_ends_with_130_in_a_line(navtwin, board_runs):
    board_runs["raises"] = KeyboardInterrupt()
    done = navtwin("run", "car_mems")
    assert done.exit_code == 130
    assert done.stderr == "navtwin: interrupted; what was written so far is marked as incomplete\n"


SLOW_RUN = """
import sys, time, types
sys.path.insert(0, sys.argv[1])
import synthetic_run
from host.record.recorder import Recorder
def run(request):
    with Recorder(synthetic_run.manifest(), request.out_dir) as recorder:
        synthetic_run.feed(recorder)
        print("running", flush=True)
        time.sleep(60)
module = types.ModuleType("host.run.runner")
module.run = run
sys.modules["host.run.runner"] = module
sys.argv[1:] = ["run", "car_mems", "--out", "cut"]
from host.cli.main import main
main()
"""


def test_ctrl_c_in_a_real_process_leaves_a_marked_folder(tmp_path):
    command = [sys.executable, "-c", SLOW_RUN, str(Path(__file__).parent)]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(
        command, cwd=tmp_path, text=True, env=os.environ | {"PYTHONPATH": str(ROOT)}, **pipes
    ) as run:
        assert run.stdout.readline() == "running\n"
        run.send_signal(signal.SIGINT)
        _, messages = run.communicate(timeout=20)
    assert run.returncode == 130
    assert messages == "navtwin: interrupted; what was written so far is marked as incomplete\n"
    assert json.loads((tmp_path / "cut" / "manifest.json").read_text())["status"] == "interrupted by the user"
    assert (tmp_path / "cut" / "run.mcap.part").is_file()


def test_a_defect_shows_where_and_is_not_taken_for_a_verdict(navtwin, board_runs, capsys):
    board_runs["raises"] = ZeroDivisionError("in the filter")
    done = navtwin("run", "car_mems")
    assert done.exit_code == 3
    assert "ZeroDivisionError: in the filter" in done.stderr
    assert "the run failed" in done.stderr


def test_a_full_disk_is_told(navtwin, board_runs):
    board_runs["raises"] = OSError(28, "No space left on device", "runs/x/run.mcap.part")
    done = navtwin("run", "car_mems")
    assert done.exit_code == 2
    assert done.stderr.startswith("navtwin: runs/x/run.mcap.part: No space left on device; free some space")
