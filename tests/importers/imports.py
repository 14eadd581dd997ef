"""Imports through the command line, and what a capture holds, read by the mcap library alone."""

from __future__ import annotations

import json
import os
from pathlib import Path

import mcap.reader
import pytest
from typer.testing import CliRunner

from host.cli.main import app

NS = 1_000_000_000


def navtwin(*arguments):
    return CliRunner().invoke(app, [str(a) for a in arguments])


def imported(tmp_path, kind, *files, name="out.mcap", options=()):
    """(report as JSON, capture)."""
    target = tmp_path / name
    outcome = navtwin("import", kind, *files, "-o", target, "--json", "-", *options)
    assert outcome.exit_code == 0, outcome.output
    assert not outcome.stderr
    return json.loads(outcome.stdout), target


def refused(tmp_path, kind, *files, options=()):
    """The one line with which an import is refused; nothing is left behind."""
    before = set(tmp_path.iterdir())
    outcome = navtwin("import", kind, *files, "-o", tmp_path / "refused.mcap", *options)
    assert outcome.exit_code == 2, outcome.output
    assert "Traceback" not in outcome.output
    assert outcome.stderr.startswith("navtwin: ")
    assert set(tmp_path.iterdir()) == before
    return outcome.stderr


def rows(capture, topic):
    """JSON messages of a topic, in order."""
    with Path(capture).open("rb") as file:
        reader = mcap.reader.make_reader(file, validate_crcs=True)
        return [json.loads(message.data) for _, _, message in reader.iter_messages(topics=[topic])]


def kinds(report):
    """(kind, channel) of findings with their counts."""
    return {(one["kind"], one["channel"]): one["count"] for one in report["findings"]}


def recording(name):
    """A real recording; the test is skipped where there is none."""
    folder = os.environ.get("NAVTWIN_DATA")
    path = Path(folder or ".") / name
    if not folder or not path.is_file():
        pytest.skip(f"NAVTWIN_DATA has no {name}")
    return path
