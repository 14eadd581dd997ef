"""The recipes for CI servers: they parse, call only what the tests here run, and docs/ci.md shows them."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import own_boards
import pytest
import yaml

from firmware.numerics.cache_folder import kernel_cache_folder
from host.new_board.writing import skeleton

FILES = skeleton(own_boards.NAME)
SCRIPT = FILES["ci/navtwin.sh"]
GITHUB = yaml.safe_load(FILES[".github/workflows/navtwin.yml"])
GITLAB = yaml.safe_load(FILES[".gitlab-ci.yml"])["navtwin"]
STEPS = GITHUB["jobs"]["check"]["steps"]
PAGE = (own_boards.ROOT / "docs/ci.md").read_text(encoding="utf-8")


@pytest.fixture
def repository(tmp_path):
    return own_boards.new_repository(tmp_path)


@pytest.mark.parametrize(
    ("path", "options"),
    [
        (".github/workflows/navtwin.yml", ["--builtin-schema", "vendor.github-workflows"]),
        (".gitlab-ci.yml", ["--builtin-schema", "vendor.gitlab-ci", "--data-transform", "gitlab-ci"]),
    ],
)
def test_the_servers_files_keep_the_published_schemas(tmp_path, path, options):
    file = tmp_path / "recipe.yml"
    file.write_text(FILES[path])
    command = [sys.executable, "-m", "check_jsonschema", *options, str(file)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    file.write_text(FILES[path].replace("script:", "scripts:").replace("runs-on:", "runs_on:"))
    assert subprocess.run(command, capture_output=True, check=False).returncode == 1


@pytest.mark.parametrize("reader", [["sh", "-n"], ["dash", "-n"], ["bash", "-n"], ["shellcheck"]])
def test_the_script_is_good_for_every_shell(tmp_path, reader):
    if shutil.which(reader[0]) is None:
        pytest.skip(f"{reader[0]} is not installed")
    file = tmp_path / "navtwin.sh"
    file.write_text(SCRIPT)
    done = subprocess.run([*reader, str(file)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_both_servers_only_call_the_script():
    lines = [step["run"] for step in STEPS if "run" in step]
    key = 'echo "key=$(ci/navtwin.sh cache-key)" >>"$GITHUB_OUTPUT"'
    assert lines == ["ci/navtwin.sh install", key, "ci/navtwin.sh check"]
    assert GITLAB["script"] == ["ci/navtwin.sh install", "ci/navtwin.sh check"]
    assert set(re.findall(r"^(\S+)\) \w+ ;;$", SCRIPT, re.M)) == {"install", "cache-key", "check"}


def test_the_cache_is_where_compiled_kernels_are_kept(monkeypatch, tmp_path):
    (cache,) = [step["with"] for step in STEPS if step.get("uses", "").startswith("actions/cache@")]
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    assert kernel_cache_folder("test").is_relative_to(Path(cache["path"]).expanduser())
    assert cache["key"].startswith(cache["restore-keys"])
    project = tmp_path / "project"
    monkeypatch.setenv(
        "XDG_CACHE_HOME", GITLAB["variables"]["XDG_CACHE_HOME"].replace("$CI_PROJECT_DIR", str(project))
    )
    (path,) = GITLAB["cache"]["paths"]
    assert kernel_cache_folder("test").is_relative_to(project / path)


def test_results_are_collected_from_where_the_script_puts_them():
    (upload,) = [step for step in STEPS if step.get("uses", "").startswith("actions/upload-artifact@")]
    assert (upload["if"], upload["with"]["path"]) == ("always()", "build")
    for path in GITLAB["artifacts"]["reports"]["junit"]:
        assert path in SCRIPT
    assert GITLAB["artifacts"]["when"] == "always"


def test_the_cache_key_is_a_word_that_follows_the_kernels(repository, tmp_path):
    environment = own_boards.environment(tmp_path / "tools")
    keys = []
    for addition in ("", "", "# changed\n"):
        with (repository / "tilt_unit/kernels.py").open("a") as file:
            file.write(addition)
        done = own_boards.call(["ci/navtwin.sh", "cache-key"], repository, environment)
        assert done.returncode == 0, done.stdout
        keys.append(done.stdout.strip())
    assert re.fullmatch(r"[0-9a-f]{16}", keys[0])
    assert keys[0] == keys[1] != keys[2]


def test_installing_asks_pip_for_what_navtwin_names(repository, tmp_path):
    """pip itself is left out: a python that only tells what it was asked."""
    environment = own_boards.environment(tmp_path / "tools", NAVTWIN="navtwin==0.1.0")
    (tmp_path / "tools/python").write_text('#!/bin/sh\necho "$@"\n')
    done = own_boards.call(["ci/navtwin.sh", "install"], repository, environment)
    assert done.stdout.splitlines() == [
        "-m pip install --quiet navtwin==0.1.0",
        "-m pip install --quiet --editable .[test]",
    ]


def test_a_run_that_cannot_start_fails_the_check(repository, tmp_path):
    (repository / "tests/test_tilt_unit.py").write_text("def test_nothing(): pass\n")
    (repository / "tilt_unit/board.toml").write_text("name = 1\n")
    summary = tmp_path / "summary.md"
    environment = own_boards.environment(tmp_path / "tools", GITHUB_STEP_SUMMARY=str(summary))
    done = own_boards.call(["ci/navtwin.sh", "check"], repository, environment)
    assert done.returncode == 2
    assert "board.toml" in done.stdout
    assert not summary.exists()


def test_a_cache_that_others_could_write_to_is_closed_first(repository, tmp_path):
    kernels = tmp_path / "cache/navtwin/kernels"
    kernels.mkdir(parents=True)
    for folder in (kernels, kernels.parent):
        folder.chmod(0o777)
    (tmp_path / "tools").mkdir()
    environment = own_boards.environment(tmp_path / "tools", XDG_CACHE_HOME=str(tmp_path / "cache"))
    (tmp_path / "tools/python").write_text("#!/bin/sh\n")
    (tmp_path / "tools/navtwin").write_text("#!/bin/sh\n")
    assert own_boards.call(["ci/navtwin.sh", "check"], repository, environment).returncode == 0
    assert [folder.stat().st_mode & 0o022 for folder in (kernels, kernels.parent)] == [0, 0]


def test_an_unknown_word_ends_with_2(repository, tmp_path):
    done = own_boards.call(
        ["ci/navtwin.sh", "deploy"], repository, own_boards.environment(tmp_path / "tools")
    )
    assert (done.returncode, done.stdout) == (2, "usage: ci/navtwin.sh install|cache-key|check\n")


@pytest.mark.parametrize("path", ["ci/navtwin.sh", ".github/workflows/navtwin.yml", ".gitlab-ci.yml"])
def test_the_page_shows_the_files_as_they_are_written(path):
    shown = re.search(rf"^`{re.escape(path)}`:\n\n```\w+\n(.*?)^```$", PAGE, re.M | re.S)
    assert shown is not None, path
    assert shown[1] == FILES[path]


def test_the_page_shows_the_test_of_a_new_board():
    blocks = re.findall(r"^```python\n(.*?)^```$", PAGE, re.M | re.S)
    assert any(block in FILES["tests/test_tilt_unit.py"] for block in blocks)
