"""A board made by `navtwin new board`, and commands run beside it as its owner would."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from host.new_board.writing import write_board

ROOT = Path(__file__).parents[2]
NAME = "tilt_unit"


def new_repository(folder: Path) -> Path:
    """A fresh repository of the board below `folder`."""
    write_board(NAME, folder / "repository")
    return folder / "repository"


def environment(tools: Path, *places: Path, **more: str) -> dict[str, str]:
    """With `navtwin` and `python` of this run on the PATH, and `places` to import from."""
    tools.mkdir(exist_ok=True)
    navtwin = tools / "navtwin"
    navtwin.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m host.cli.main "$@"\n')
    navtwin.chmod(0o755)
    python = tools / "python"
    python.write_text(f'#!/bin/sh\nexec "{sys.executable}" "$@"\n')
    python.chmod(0o755)
    path = os.pathsep.join([str(tools), os.environ["PATH"]])
    imports = os.pathsep.join(map(str, (ROOT, *places)))
    return {**plain_environment(), "PATH": path, "PYTHONPATH": imports, "COLUMNS": "140", **more}


def plain_environment() -> dict[str, str]:
    """The present one, without what the test runner or CI around this test has put there."""
    own = ("PYTEST_", "GITHUB_", "PYTHONPATH", "NAVTWIN_DATA")
    return {key: value for key, value in os.environ.items() if not key.startswith(own)}


def call(words: list[str], folder: Path, environment: dict[str, str]) -> subprocess.CompletedProcess[str]:
    """A command and what it says, both streams together in `stdout`."""
    return subprocess.run(
        words, cwd=folder, env=environment, text=True, timeout=120, check=False,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    )  # fmt: skip
