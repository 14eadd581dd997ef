"""The boards and the chip that the documentation builds are real: written out, they run and pass."""

import json
import os
import subprocess
import sys

import pytest
from pages import ROOT, commands, navtwin, write_files


@pytest.fixture(scope="module")
def places(tmp_path_factory):
    """For each page the folder its files were written to."""
    found = {}
    for page in ("docs/add-a-board.md", "docs/add-a-chip.md"):
        found[page] = tmp_path_factory.mktemp("page")
        assert write_files(page, found[page])
    return found


@pytest.mark.parametrize(("page", "kind", "code", "count"), [
    ("docs/add-a-board.md", "sh", 0, 4),
    ("docs/add-a-board.md", "sh-fails", 1, 1),
    ("docs/add-a-chip.md", "sh", 0, 1),
])  # fmt: skip
def test_commands_of_the_page(places, page, kind, code, count):
    found = commands(page, kind)
    assert len(found) == count
    for program, *words in found:
        assert program == "navtwin"
        ended = navtwin([*words, "--no-capture"], places[page])
        assert ended.returncode == code, f"{words}\n{ended.stdout}\n{ended.stderr}"
        assert "Traceback" not in ended.stderr


def test_the_broken_wire_is_seen_where_the_page_says(places):
    words = ["run", "tilt", "-s", "loose-wire", "--no-capture", "--quiet", "--json", "-"]
    result = json.loads(navtwin(words, places["docs/add-a-board.md"]).stdout)
    missed = [one["name"] for one in result["expectations"] if not one["ok"]]
    assert "continuous_pitch_max_deg" in missed
    assert "deadline_misses" not in missed
    assert result["faults"][0]["fired"] > 0


def test_the_chip_tells_gravity(places):
    ended = navtwin(["run", "plumb", "--no-capture"], places["docs/add-a-chip.md"])
    told = [int(part.split()[0]) for part in ended.stdout.split("z = ")[1:]]
    assert len(told) == 4
    assert all(abs(value + 1000) < 150 for value in told)


def test_what_the_model_leaves_out_is_an_event_of_the_run(tmp_path):
    write_files("docs/add-a-chip.md", tmp_path)
    program = tmp_path / "plumb" / "plumb_program.py"
    program.write_text(program.read_text().replace("(0x01, 0x01)", "(0x01, 0x11)"))
    result = json.loads(navtwin(["run", "plumb", "--no-capture", "-q", "--json", "-"], tmp_path).stdout)
    told = [event for event in result["events"] if event["source"] == "U1"]
    assert [event["text"] for event in told] == ["not modelled: CTRL: self-test, 1 times"]


def test_the_tests_of_the_chip_pass(places):
    folder = places["docs/add-a-chip.md"] / "plumb"
    environment = {**os.environ, "PYTHONPATH": f"{ROOT}{os.pathsep}{folder}"}
    ended = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_acc1.py"],
        cwd=folder,
        env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert ended.returncode == 0, ended.stdout
    assert "3 passed" in ended.stdout
