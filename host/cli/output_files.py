"""Files that are asked for besides a run's folder. With `--json -` people read on standard error."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rich.console import Console

from host.cli.terminal import standard_error, standard_output
from host.record.atomic import refuse_device, write_whole
from host.record.errors import UserError

STANDARD_OUTPUT = "-"


def write_json(document: Mapping[str, Any], target: str | None) -> None:
    """The figures, if wanted. Raises UserError when the file cannot be written."""
    if target is None:
        return
    text = json.dumps(document, indent=1) + "\n"
    if target == STANDARD_OUTPUT:
        print(text, end="")
    else:
        write_whole(Path(target), text, "--json")


def for_people(target: str | None) -> Console:
    """Standard output, unless the figures go there."""
    return standard_error() if target == STANDARD_OUTPUT else standard_output()


def check_files(*files: tuple[str, str | Path | None], read: Path | None = None) -> None:
    """Tell before long work that a file could not be written after it, that two would be one, or that one
    would take the place of what is `read`. Raises UserError."""
    taken = {} if read is None else {read.resolve(): "the file that is read"}
    for option, name in files:
        if name is None or str(name) == STANDARD_OUTPUT:
            continue
        path = Path(name)
        whole = path.resolve()
        if whole in taken:
            raise UserError(
                f"{option} {path}: is {taken[whole]} too; name another one, e.g. {option} new-{path.name}"
            )
        taken[whole] = f"the file of {option}"
        refuse_device(path, option)
        if path.is_dir():
            raise UserError(f"{option} {path}: is a folder; name a file, e.g. {option} {path / 'result'}")
        if not path.parent.is_dir():
            raise UserError(f"{option} {path}: the folder {path.parent} does not exist")
        if not os.access(path.parent, os.W_OK):
            raise UserError(f"{option} {path}: the folder {path.parent} is not writable")
