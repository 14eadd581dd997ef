"""NumPy archives (.npz) of recordings: read whole, since they are minutes long."""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from host.importers.series import Floats
from host.record.errors import UserError


def arrays_of(
    path: Path, keys: Mapping[str, int | None], optional: Sequence[str], kind: str
) -> dict[str, Floats]:
    """Arrays as float64. `keys`: needed ones with their number of columns (None: a plain row of numbers).

    Raises UserError when the file is none, or lacks one, or one has another shape.
    """
    try:
        loaded = np.load(path, allow_pickle=False)
        if isinstance(loaded, np.ndarray):
            raise UserError(f"{path}: is a single array; {kind} is an archive (.npz) of {', '.join(keys)}")
        with loaded as archive:
            names = archive.files
            missing = [key for key in keys if key not in names]
            if missing:
                has = ", ".join(names) or "nothing"
                raise UserError(f"{path}: not {kind} arrays, it lacks {', '.join(missing)}; it has {has}")
            wanted = [*keys, *(key for key in optional if key in names)]
            data = {key: as_numbers(archive[key]) for key in wanted}
    except (OSError, ValueError, TypeError, EOFError, KeyError, zipfile.BadZipFile, zlib.error) as error:
        cause = str(error).partition(". ")[0]
        names = ", ".join(keys)
        raise UserError(
            f"{path}: cannot be read as a NumPy archive: {cause}; {kind} is an archive (.npz) of {names}"
        ) from None
    for key, width in keys.items():
        shape = data[key].shape
        if len(shape) != (1 if width is None else 2) or (width is not None and shape[1] != width):
            raise UserError(
                f"{path}: {key} has the shape {shape}; {kind} has (n{'' if width is None else f', {width}'})"
            )
    return data


def as_numbers(values: Any) -> Floats:
    """As float64. TypeError or ValueError for what is no array of real numbers."""
    if np.iscomplexobj(values):
        raise TypeError("complex numbers")
    return np.asarray(values, np.float64)
