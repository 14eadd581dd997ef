"""The pages of the documentation as tests see them: files, commands and links."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").rglob("*.md"))]

FILE = re.compile(r"^`([\w./-]+)`:\n\n```\w+\n(.*?)^```$", re.M | re.S)
COMMANDS = re.compile(r"^```(sh|sh-fails)\n(.*?)^```$", re.M | re.S)


def text(page: str) -> str:
    """A page by its path from the root."""
    return (ROOT / page).read_text(encoding="utf-8")


def write_files(page: str, folder: Path) -> list[Path]:
    """Write every named file of a page below `folder`."""
    written = []
    for name, content in FILE.findall(text(page)):
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content, encoding="utf-8")
        written.append(path)
    return written


def commands(page: str, kind: str = "sh") -> list[list[str]]:
    """The commands of a page's blocks, as words, without comments."""
    blocks = [body for found, body in COMMANDS.findall(text(page)) if found == kind]
    lines = [line for body in blocks for line in body.replace("\\\n", " ").splitlines()]
    return [words for words in (shlex.split(line, comments=True) for line in lines) if words]


def navtwin(words: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    """Run the command line from `folder`."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "COLUMNS": "140"}
    return subprocess.run(
        [sys.executable, "-m", "host.cli.main", *words],
        cwd=folder, env=environment, capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
