"""Writes the skeleton of a board: all of it or nothing, and never over a file that is there.

Everything is written into a folder aside first, then renamed into place.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib.resources import files
from pathlib import Path

from host.new_board.names import check_name
from host.record.errors import UserError

PLACEHOLDER = "__board__"
FILES = {
    "README.md": "readme.md",
    "pyproject.toml": "pyproject.toml",
    ".gitignore": "gitignore",
    ".github/workflows/navtwin.yml": "github.yml",
    ".gitlab-ci.yml": "gitlab.yml",
    "ci/navtwin.sh": "navtwin.sh",
    "tests/test___board__.py": "test_board.py",
    "__board__/__init__.py": "init.py",
    "__board__/board.toml": "board.toml",
    "__board__/program.py": "program.py",
    "__board__/kernels.py": "kernels.py",
    "__board__/scenarios/drive.toml": "drive.toml",
    "__board__/scenarios/loose-wire.toml": "loose-wire.toml",
}
"""Path in the new repository and its template; the name stands for `__board__` in both."""


def skeleton(name: str) -> dict[str, str]:
    """The files of a new board: path and text."""
    templates = files("host.new_board") / "skeleton"
    return {
        path.replace(PLACEHOLDER, name): (templates / f"{template}.template")
        .read_text(encoding="utf-8")
        .replace(PLACEHOLDER, name)
        for path, template in FILES.items()
    }


def write_board(name: str, folder: Path) -> list[Path]:
    """Write the skeleton of the board `name` below `folder`, which is made if it is not there.

    Returns the files. Raises UserError for a name or a place that will not do; then nothing has been written.
    """
    check_name(name)
    if folder.exists() and not folder.is_dir():
        raise UserError(f"--dir {folder}: is a file; name a folder, for example --dir {name}")
    content = skeleton(name)
    there = [path for path in content if os.path.lexists(folder / path)]
    if there:
        raise UserError(
            f"--dir {folder}: {', '.join(there)} already there, nothing is overwritten;"
            f" name another folder, for example --dir {folder / name}"
        )
    made: list[Path] = []
    with _told(folder):
        try:
            _make_folder(folder, made)
            return _write_aside_and_move(content, folder, made)
        except BaseException:
            for place in reversed(made):
                with suppress(OSError):  # somebody has put something into it meanwhile
                    place.rmdir()
            raise


def _make_folder(folder: Path, made: list[Path]) -> None:
    """Make `folder`; those that were not there before are added to `made`."""
    missing = [place for place in (folder, *folder.parents) if not place.exists()]
    for place in reversed(missing):
        place.mkdir()
        made.append(place)


def _write_aside_and_move(content: dict[str, str], folder: Path, made: list[Path]) -> list[Path]:
    aside = Path(tempfile.mkdtemp(prefix=".navtwin-new-", dir=folder))
    moved: list[Path] = []
    try:
        for path, text in content.items():
            part = aside / path
            part.parent.mkdir(parents=True, exist_ok=True)
            part.write_text(text, encoding="utf-8")
            if text.startswith("#!"):
                part.chmod(part.stat().st_mode | 0o111)
        for path in content:
            place = folder / path
            _make_folder(place.parent, made)
            if os.path.lexists(place):
                raise FileExistsError(17, "appeared meanwhile", str(place))
            (aside / path).rename(place)
            moved.append(place)
    except BaseException:
        for place in moved:
            place.unlink(missing_ok=True)
        raise
    finally:
        shutil.rmtree(aside, ignore_errors=True)
    return moved


@contextmanager
def _told(folder: Path) -> Iterator[None]:
    """What the file system refuses becomes one message."""
    try:
        yield
    except OSError as error:
        where = error.filename or folder
        raise UserError(f"--dir {folder}: {where}: cannot be written: {error.strerror}") from None
