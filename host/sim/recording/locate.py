"""Where real recordings lie: the folder given with --data, or the environment variable NAVTWIN_DATA."""

from __future__ import annotations

import os
from pathlib import Path

from host.sim.scenario.errors import ScenarioError

VARIABLE = "NAVTWIN_DATA"


def recording_path(file: str, data_dir: Path | None) -> Path:
    """The recording `file` below the data folder. ScenarioError that says how to name the folder."""
    given = os.environ.get(VARIABLE)
    folder = data_dir if data_dir is not None else Path(given) if given else None
    if folder is None:
        raise ScenarioError(
            f"recording.file = {file!r} needs the folder of recordings: give it with --data DIR or in "
            f"{VARIABLE}, for example {VARIABLE}=~/recordings"
        )
    path = folder.expanduser() / file
    if not path.is_file():
        origin = "--data" if data_dir is not None else VARIABLE
        raise ScenarioError(
            f"recording.file = {file!r}: no such file below {folder} (from {origin}); "
            f"the folder must hold {file}"
        )
    return path
