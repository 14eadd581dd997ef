"""The worked example of docs/ci.md: a new board passes its gate; broken, it fails with a useful message."""

import json
import re
import shlex
import subprocess
import sys
import textwrap
from xml.etree import ElementTree

import own_boards
import pytest

PAGE = (own_boards.ROOT / "docs/ci.md").read_text(encoding="utf-8")
ADDED_LINE = "        attitude[1] = -attitude[1]\n"


def block(kind: str, containing: str = "") -> str:
    """The first block of that kind on the page with that text in it."""
    return next(
        found for found in re.findall(rf"^```{kind}\n(.*?)^```$", PAGE, re.M | re.S) if containing in found
    )


@pytest.fixture(scope="module")
def environment(tmp_path_factory):
    return own_boards.environment(tmp_path_factory.mktemp("tools"))


@pytest.fixture(scope="module")
def checked(environment, tmp_path_factory):
    """The commands of the page, as on CI: (what they said, the repository they made, the page of the job)."""
    folder = tmp_path_factory.mktemp("gate")
    summary = folder / "summary.md"
    summary.write_text("before\n")
    done = own_boards.call(
        ["sh", "-e", "-c", block("sh")], folder, {**environment, "GITHUB_STEP_SUMMARY": str(summary)}
    )
    return done, folder / "tilt_unit", summary


@pytest.fixture(scope="module")
def repository(checked):
    return checked[1]


@pytest.fixture(scope="module")
def side_by_side(repository, environment):
    """Tests in two processes of pytest-xdist, one of them the example of the page."""
    example = textwrap.indent(block("python", "run.result"), "    ")
    (repository / "tests/test_page.py").write_text(f"def test_page(navtwin_run):\n{example}")
    words = ["python", "-m", "pytest", "-n", "2", "-k", "seeds or page", "--navtwin-out", "build/workers"]
    return own_boards.call(words, repository, environment)


@pytest.fixture(scope="module")
def broken(repository, environment, side_by_side):
    """The same after a sign was lost in the program."""
    program = repository / "tilt_unit/program.py"
    text = program.read_text()
    attitude = "        attitude = self._f[kernels.EULER : kernels.EULER + 3].tolist()\n"
    assert attitude in text
    assert ADDED_LINE in PAGE
    program.write_text(text.replace(attitude, attitude + ADDED_LINE))
    return own_boards.call(["python", "-m", "pytest", "-k", "seeds or deadlines"], repository, environment)


def test_a_new_board_passes_its_gate(checked):
    done, repository, summary = checked
    assert done.returncode == 0, done.stdout
    assert "6 passed" in done.stdout
    assert len(re.findall(r"all \d expectations met", done.stdout)) == 2
    assert summary.read_text() == "before\n" + (repository / "build/drive.md").read_text()
    assert "expectations met" in summary.read_text()


def test_the_results_are_where_ci_looks_for_them(repository):
    cases = ElementTree.parse(repository / "build/drive.xml").getroot().findall(".//testcase")
    judged = json.loads((repository / "build/drive/result.json").read_text())["expectations"]
    assert [case.get("name", "").split()[0] for case in cases] == [one["name"] for one in judged]
    assert {"continuous_yaw_rms_deg", "cpu.mcu.load"} < {one["name"] for one in judged}
    tests = ElementTree.parse(repository / "build/tests.xml").getroot().findall(".//testcase")
    assert len(tests) == 6
    told = {item.get("name"): item.get("value") for item in tests[1].iter("property")}
    assert re.fullmatch(r"0\.\d+ <= 0\.7", told["continuous_roll_rms_deg"])
    kept = [path.name for path in (repository / "build/runs").iterdir()]
    assert "tilt_unit-default-2" in kept
    assert all((repository / "build/runs" / name / "report.html").is_file() for name in kept)


def test_workers_of_xdist_keep_their_runs_apart(side_by_side, repository):
    assert "3 passed" in side_by_side.stdout, side_by_side.stdout
    kept = sorted(path.relative_to(repository) for path in repository.glob("build/workers/*/*/report.html"))
    assert {path.parts[2] for path in kept} == {"gw0", "gw1"}
    assert len(kept) == 3


def test_a_broken_program_fails_with_figure_value_limit_and_seed(broken):
    assert broken.returncode == 1
    assert re.search(
        r"NOT MET  continuous_pitch_rms_deg +[1-9][.\d]*, limit ≤ 0\.7  \(exact: [\d.]+ <= 0\.7\)",
        broken.stdout,
    )
    assert re.search(r"OK       continuous_yaw_rms_deg +0\.", broken.stdout)
    assert "tilt_unit drive standard seed 2: 1 of 4 expectations NOT MET" in broken.stdout
    assert "2 failed, 1 passed, 4 deselected" in broken.stdout  # deadlines are kept


def test_the_page_shows_the_message(broken):
    def shape(text: str) -> list[str]:
        return [re.sub(r"\d+(\.\d+)?", "0", line).strip() for line in text.splitlines()]

    shown, told = shape(block("text", "NOT MET")), shape(broken.stdout)
    assert len(shown) == 7
    begin = told.index(shown[0])
    assert told[begin : begin + len(shown)] == shown


def test_the_command_of_the_message_fails_in_the_same_way(broken, repository, environment):
    commands = re.findall(r"reproduce: (navtwin run .*--seed 2.*)", broken.stdout)
    assert commands
    words = [*shlex.split(commands[0]), "--no-capture", "--quiet"]
    assert words[2] == "./tilt_unit"
    again = own_boards.call(words, repository, environment)
    assert again.returncode == 1
    assert "1 of 4 expectations NOT MET" in again.stdout


# -- beside projects that do not use it --------------------------------------------------------------


def test_the_plugin_brings_in_nothing():
    script = "import sys, pytest; before = set(sys.modules); import navtwin_pytest;"
    script += "print(sorted(set(sys.modules) - before))"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "['navtwin_pytest']"


def test_a_project_with_packages_of_the_same_names_is_left_alone(tmp_path):
    for name in ("host", "boards", "firmware", "hal"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text("MINE = True\n")
    (tmp_path / "test_mine.py").write_text(
        "import boards, firmware, hal, host\n\n"
        "def test_mine(pytestconfig):\n"
        "    assert host.MINE and boards.MINE and firmware.MINE and hal.MINE\n"
        "    assert pytestconfig.pluginmanager.hasplugin('navtwin')\n"
    )
    words = [sys.executable, "-m", "pytest", "-q", "--strict-markers", "-p", "no:cacheprovider"]
    done = own_boards.call([*words, "--rootdir", "."], tmp_path, own_boards.plain_environment())
    assert done.returncode == 0, done.stdout
    assert "1 passed" in done.stdout
