"""Task figures of a finished run from beside its capture, for boards that do not tell them themselves."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from host.link.messages import TaskFigures
from host.monitor.state import TaskLoad

CAPTURE, RESULT = "run.mcap", "result.json"
MOST = 64


def tasks_of_run(capture: Path) -> tuple[TaskLoad, ...]:
    """The tasks of all processors, with their load over the whole run; empty when nobody has told them."""
    if capture.name != CAPTURE:
        return ()
    try:
        result = json.loads((capture.parent / RESULT).read_text(encoding="utf-8"))
        tasks = [_load(task) for cpu in result["cpu"] for task in cpu["tasks"]]
    except (OSError, ValueError, KeyError, TypeError, OverflowError):
        return ()
    return tuple(tasks[:MOST])


def _load(task: dict[str, Any]) -> TaskLoad:
    counts = int(task["activations"]), 0, int(task["worst_response_us"]), int(task["deadline_misses"])
    return TaskLoad(TaskFigures(str(task["name"]), *counts), 0, float(task["load"]))
