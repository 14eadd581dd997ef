"""The folder that one run writes: manifest.json, result.json, solution.csv, run.mcap, report.html.

While a run is under way, and after one that did not reach its end, `manifest.json` says so in `status`
and the growing files carry `.part` behind their names. Files of an earlier run in the same folder are
removed first, so that a folder never mixes two runs. A folder that holds anything else, or into which another
process is writing, is not touched.
"""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from host.record.atomic import write_whole
from host.record.errors import UserError
from host.record.manifest import MANIFEST_FORMAT

GROWING = ("solution.csv", "run.mcap")
OWN_FILES = ("result.json", "report.html", *GROWING, *(f"{name}.part" for name in GROWING), "manifest.json")

LOGS = "*.bin"
"""What boards write to their logs."""
SCREENS = "screen-*.png"
"""What was seen on their displays."""


class RunFolder:
    """One run's folder, created and emptied of an earlier run. Raises UserError when that cannot be."""

    def __init__(self, path: Path, manifest: Mapping[str, Any]) -> None:
        self.path = path
        self._manifest = dict(manifest)
        self._claim: int | None = None
        _must_be_ours(path)
        try:
            path.mkdir(parents=True, exist_ok=True)
            self._claim = _claimed(path)
            for file in (*(path / name for name in OWN_FILES), *path.glob(LOGS), *path.glob(SCREENS)):
                file.unlink(missing_ok=True)
        except OSError as error:
            self.release()
            raise UserError(f"--out {path}: cannot be written: {error.strerror}") from None
        self.set_status("running")

    def release(self) -> None:
        """Nothing more will be written."""
        if self._claim is not None:
            os.close(self._claim)
            self._claim = None

    def file(self, name: str) -> Path:
        """Path of one of the run's files."""
        return self.path / name

    def set_status(self, status: str, **more: Any) -> None:
        """Write the manifest with a new status ("running", "complete", "interrupted …")."""
        manifest = self._manifest | {"status": status} | more
        text = json.dumps(manifest, indent=1) + "\n"
        try:
            write_whole(self.file("manifest.json"), text, "--out")
        except UserError:
            self._overwrite(text)
            raise

    def _overwrite(self, text: str) -> None:
        """On a full disk the new manifest finds room where the old one stands, if anywhere."""
        with contextlib.suppress(OSError), self.file("manifest.json").open("r+", encoding="utf-8") as file:
            file.write(text)
            file.truncate()


def _claimed(path: Path) -> int | None:
    """A descriptor that holds the folder against other processes; None where a system cannot do that."""
    try:
        import fcntl
    except ImportError:
        return None
    folder = os.open(path, os.O_RDONLY)
    try:
        fcntl.flock(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(folder)
        raise UserError(
            f"--out {path}: another run is writing there; name another folder, e.g. --out runs/second"
        ) from None
    except OSError:
        os.close(folder)
        return None
    return folder


def _must_be_ours(path: Path) -> None:
    """Nothing, an empty folder or an earlier run's folder: everything else belongs to somebody."""
    try:
        if not path.exists():
            return
        if not path.is_dir():
            raise UserError(f"--out {path}: is a file; name a folder, e.g. --out runs/first")
        if not any(path.iterdir()):
            return
        manifest = json.loads((path / "manifest.json").read_text(encoding="utf-8"))
        ours = isinstance(manifest, dict) and manifest.get("format") == MANIFEST_FORMAT
    except (FileNotFoundError, ValueError):
        ours = False
    except OSError as error:
        raise UserError(f"--out {path}: cannot be read: {error.strerror}") from None
    if not ours:
        raise UserError(
            f"--out {path}: the folder exists and does not hold a navtwin run; "
            "name a new folder, e.g. --out runs/first"
        )
