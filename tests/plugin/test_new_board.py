"""`navtwin new board`: what it writes, what it refuses, and how the board is found afterwards."""

import json
import shutil
import sys
from pathlib import Path

import own_boards
import pytest
from typer.testing import CliRunner

from boards.description import load_board
from boards.places import board_folder
from boards.validation import DescriptionError
from host.cli.main import app
from host.new_board import writing
from host.record.errors import UserError
from host.record.result import RunRequest
from host.run.setup import resolve


@pytest.fixture
def navtwin(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    runner = CliRunner()
    return lambda *arguments: runner.invoke(app, [str(argument) for argument in arguments])


@pytest.fixture
def import_state(monkeypatch):
    """Modules and search path as before, whatever a board brings in."""
    before = set(sys.modules)
    monkeypatch.setattr(sys, "path", [*sys.path])
    yield
    for name in set(sys.modules) - before:
        del sys.modules[name]


def files(folder: Path) -> dict[str, str]:
    found = (path for path in sorted(folder.rglob("*")) if path.is_file())
    return {str(path.relative_to(folder)): path.read_text() for path in found}


def test_everything_carries_the_name_and_nothing_is_left_aside(navtwin, tmp_path):
    done = navtwin("new", "board", "tilt_unit")
    assert done.exit_code == 0, done.output
    written = files(tmp_path / "tilt_unit")
    assert set(written) == {path.replace("__board__", "tilt_unit") for path in writing.FILES}
    assert not any("__board__" in text for text in written.values())
    assert [path.name for path in tmp_path.iterdir()] == ["tilt_unit"]
    assert (tmp_path / "tilt_unit/ci/navtwin.sh").stat().st_mode & 0o111 == 0o111
    assert "navtwin run tilt_unit" in done.output


def test_every_template_is_used():
    templates = Path(writing.__file__).parent / "skeleton"
    assert {path.name for path in templates.iterdir()} == {
        f"{name}.template" for name in writing.FILES.values()
    }


def test_it_goes_into_a_repository_that_is_there(navtwin, tmp_path):
    (tmp_path / "mine/tests").mkdir(parents=True)
    (tmp_path / "mine/tests/test_other.py").write_text("kept")
    assert navtwin("new", "board", "tilt_unit", "--dir", "mine").exit_code == 0
    assert (tmp_path / "mine/tests/test_other.py").read_text() == "kept"
    assert (tmp_path / "mine/tests/test_tilt_unit.py").is_file()


@pytest.mark.parametrize("there", ["README.md", "tilt_unit/board.toml", "ci/navtwin.sh"])
def test_what_is_there_is_never_overwritten(navtwin, tmp_path, there):
    (tmp_path / "mine" / there).parent.mkdir(parents=True)
    (tmp_path / "mine" / there).write_text("precious")
    done = navtwin("new", "board", "tilt_unit", "--dir", "mine")
    assert done.exit_code == 2
    assert there in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert files(tmp_path / "mine") == {there: "precious"}


@pytest.mark.parametrize("name", [
    "Tilt", "2tilt", "tilt-unit", "", "tilt unit", "../tilt", "tilt/x", "ünit", "class", "json", "numpy",
    "hal", "host", "navtwin", "tests", "car_mems", "t" * 41,
])  # fmt: skip
def test_a_name_that_will_not_do_is_told_in_one_line(navtwin, tmp_path, name):
    done = navtwin("new", "board", name)
    assert done.exit_code == 2
    (line,) = done.stderr.splitlines()
    assert line.startswith(f"navtwin: board name {name!r}: ")
    assert "for example " in line
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("place", ["a_file", "a_file/below", "/proc/navtwin"])
def test_a_place_that_will_not_do_is_told_in_one_line(navtwin, tmp_path, place):
    (tmp_path / "a_file").write_text("kept")
    done = navtwin("new", "board", "tilt_unit", "--dir", place)
    assert done.exit_code == 2
    assert len(done.stderr.splitlines()) == 1
    assert place in done.stderr
    assert files(tmp_path) == {"a_file": "kept"}


@pytest.mark.parametrize("into", ["new/folders", "."])
def test_a_full_disk_leaves_nothing_behind(tmp_path, monkeypatch, into):
    rename = Path.rename

    def fail_late(self, target):
        if Path(target).name == "program.py":
            raise OSError(28, "No space left on device", str(target))
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", fail_late)
    with pytest.raises(UserError, match=r"program\.py: cannot be written: No space left"):
        writing.write_board("tilt_unit", tmp_path / into)
    assert list(tmp_path.iterdir()) == []


# -- found again -----------------------------------------------------------------------------------


@pytest.fixture
def repository(tmp_path):
    return own_boards.new_repository(tmp_path)


def test_a_board_is_found_by_its_folder_its_file_and_its_repository(repository):
    folder = repository / "tilt_unit"
    for given in (folder, folder / "board.toml", repository):
        assert board_folder(str(given)).samefile(folder)
    assert load_board(str(repository)).name == "tilt_unit"


def test_a_repository_of_two_boards_asks_which(repository):
    shutil.copytree(repository / "tilt_unit", repository / "src" / "other")
    project = repository / "pyproject.toml"
    project.write_text(
        project.read_text().replace('tilt_unit = "tilt_unit"', 'tilt_unit = "tilt_unit"\nother = "other"')
    )
    with pytest.raises(DescriptionError, match=r"holds 2 boards.*tilt_unit, .*src/other"):
        board_folder(str(repository))


def test_an_installed_board_is_found_by_name_from_anywhere(repository, tmp_path):
    site = installed(repository, tmp_path, "tilt_unit = tilt_unit")
    environment = own_boards.environment(tmp_path / "tools", repository, site)
    (tmp_path / "elsewhere").mkdir()
    words = ["navtwin", "run", "tilt_unit", "--no-capture", "--quiet", "--set", "duration_s=30.0"]
    done = own_boards.call(
        [*words, "--set", "expect={deadline_misses=0}"], tmp_path / "elsewhere", environment
    )
    assert done.returncode == 0, done.stdout
    listed = own_boards.call(["navtwin", "boards", "--json"], tmp_path / "elsewhere", environment)
    names = [board["name"] for board in json.loads(listed.stdout)]
    assert names == ["car_mems", "dual_antenna", "gfsins", "tilt_unit", "uav_ahrs"]


def test_an_entry_point_that_leads_nowhere_is_told_and_hides_no_board(repository, tmp_path):
    site = installed(repository, tmp_path, "gone = gone_package")
    environment = own_boards.environment(tmp_path / "tools", repository, site)
    done = own_boards.call(["navtwin", "run", "gone"], tmp_path, environment)
    assert done.returncode == 2
    assert done.stdout.startswith("navtwin: board 'gone': its entry point names 'gone_package'")
    listed = own_boards.call(["navtwin", "boards"], tmp_path, environment)
    assert listed.returncode == 2
    assert "car_mems" in listed.stdout
    assert "board 'gone'" in listed.stdout


def installed(repository: Path, tmp_path: Path, entry_point: str) -> Path:
    """A folder to import from, in which the metadata of an installation lie."""
    metadata = tmp_path / "site" / "tilt_unit-0.1.0.dist-info"
    metadata.mkdir(parents=True)
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: tilt_unit\nVersion: 0.1.0\n")
    (metadata / "entry_points.txt").write_text(f"[navtwin.boards]\n{entry_point}\n")
    return tmp_path / "site"


# -- modules of boards -----------------------------------------------------------------------------


def test_a_package_is_imported_from_the_top_only(repository, import_state):
    resolve(RunRequest(str(repository / "tilt_unit")))
    assert sys.path[0] == str(repository)
    assert str(repository / "tilt_unit") not in sys.path


def test_two_boards_with_modules_of_one_name_are_told_apart(tmp_path, import_state):
    for place in ("first", "second"):
        folder = own_boards.new_repository(tmp_path / place) / "tilt_unit"
        (folder / "__init__.py").unlink()
        board = folder / "board.toml"
        board.write_text(board.read_text().replace("tilt_unit.program:", "unit_program:"))
        (folder / "unit_program.py").write_text("def program(io, profile, installation): ...\n")
    resolve(RunRequest(str(tmp_path / "first/repository/tilt_unit")))
    __import__("unit_program")
    resolve(RunRequest(str(tmp_path / "first/repository/tilt_unit")))
    with pytest.raises(UserError, match=r"'unit_program' was already loaded from .*first.*my_unit_program"):
        resolve(RunRequest(str(tmp_path / "second/repository/tilt_unit")))
