"""The command line that makes a run again."""

from __future__ import annotations

import json
import os
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from host.record.errors import UserError
from host.record.result import RunRequest


def command_line(request: RunRequest, expect: Mapping[str, Any] | None = None) -> str:
    """`navtwin run …` for a POSIX shell, from the present folder; `expect` in place of the scenario's."""
    words = ["navtwin", "run", _from_here(request.board)]
    if request.scenario is not None:
        words += ["--scenario", _from_here(request.scenario)]
    if request.profile is not None:
        words += ["--profile", request.profile]
    words += ["--seed", str(request.seed)]
    for change in request.overrides:
        words += ["--set", change]
    if expect is not None:
        words += ["--set", f"expect={toml(expect)}"]
    if request.data_dir is not None:
        words += ["--data", _from_here(str(request.data_dir))]
    return shlex.join(words)


def toml(value: Any) -> str:
    """A value on one line of TOML. Raises UserError for what TOML does not have."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, int):
        return str(int(value))
    if isinstance(value, float):
        return repr(float(value))
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_key(key)} = {toml(item)}" for key, item in value.items()) + "}"
    if isinstance(value, Sequence):
        return "[" + ", ".join(map(toml, value)) + "]"
    raise UserError(
        f"{value!r}: a {type(value).__name__} cannot be given as a setting; numbers, text, lists can"
    )


def _key(key: Any) -> str:
    return json.dumps(str(key), ensure_ascii=False)


def _from_here(name_or_path: str) -> str:
    """An absolute path below the present folder, relative to it; a name stays."""
    path = Path(name_or_path)
    if not path.is_absolute():
        return name_or_path
    relative = os.path.relpath(path)
    if relative.startswith(".."):
        return name_or_path
    return relative if os.sep in relative else os.path.join(".", relative)
