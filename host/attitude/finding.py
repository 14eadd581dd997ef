"""Which recordings are meant: files as named, or below the folder of real recordings."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from host.record.errors import UserError
from host.sim.recording.locate import VARIABLE

FOLDER = "broad"
ENDINGS = (".npz", ".mat", ".hdf5")


def find_recordings(names: Sequence[str], data_dir: Path | None) -> list[Path]:
    """Files named, each as it stands or below the data folder; without names all of its folder `broad`.

    Raises UserError when one is not found.
    """
    folder = _data_folder(data_dir)
    if names:
        return [_find(name, folder) for name in names]
    if folder is None:
        raise UserError(
            f"no recording named: give files, or the folder of recordings with --data or {VARIABLE}, "
            "for example navtwin attitude 02_undisturbed_slow_rotation_B.npz"
        )
    below = folder / FOLDER
    found = sorted(path for path in below.glob("*") if path.suffix in ENDINGS)
    if not found:
        raise UserError(
            f"{below}: holds no recording ({', '.join(ENDINGS)}); BROAD trials are expected there"
        )
    return found


def _data_folder(data_dir: Path | None) -> Path | None:
    if data_dir is not None:
        if not data_dir.expanduser().is_dir():
            raise UserError(f"--data {data_dir}: no such folder")
        return data_dir.expanduser()
    given = os.environ.get(VARIABLE)
    return Path(given).expanduser() if given else None


def _find(name: str, folder: Path | None) -> Path:
    path = Path(name).expanduser()
    places = [path] if folder is None else [path, folder / name, folder / FOLDER / name]
    for place in places:
        if place.is_file():
            return place
    looked = f"; nor below {folder}" if folder is not None else ""
    if path.is_dir():
        raise UserError(f"{name}: is a folder; name recordings in it, e.g. {path / '*.npz'}")
    raise UserError(f"{name}: no such file{looked}; for example 02_undisturbed_slow_rotation_B.npz")
