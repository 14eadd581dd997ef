"""Modules of a board that lies outside: its program and chip models are found beside its board.toml.

A folder with an `__init__.py` is a package: its modules are named from the top, `tilt.program:program`, and
the folder around the outermost package is where Python looks for them. In any other folder the modules stand
by themselves, `tilt_program:program`. Two boards in one process must not call different modules alike.
"""

from __future__ import annotations

import sys
from importlib.util import find_spec
from pathlib import Path

from boards.description import Board
from host.record.errors import UserError


def make_importable(board: Board, folder: Path) -> None:
    """Let Python find what `board` in `folder` names; the folder goes before what is installed.

    Raises UserError when another file was already loaded under one of the names.
    """
    folder = folder.resolve()
    root = _root(folder)
    if root != folder and _is_installed_at(folder.relative_to(root).parts[0], root):
        return
    targets = [processor.program for processor in board.processors.values()]
    targets += [chip.model for chip in board.chips.values()]
    for target in targets:
        _must_not_be_another(target.partition(":")[0].partition(".")[0], root)
    sys.path[:] = [str(root), *(place for place in sys.path if place != str(root))]


def _root(folder: Path) -> Path:
    """The folder itself, or the one around the outermost package it lies in."""
    while (folder / "__init__.py").is_file():
        folder = folder.parent
    return folder


def _is_installed_at(package: str, root: Path) -> bool:
    """Whether `import package` already gives the one below `root`."""
    try:
        spec = find_spec(package)
    except (ImportError, ValueError):
        return False
    places = (spec.submodule_search_locations or ()) if spec is not None else ()
    return any(Path(place).resolve() == root / package for place in places)


def _must_not_be_another(name: str, root: Path) -> None:
    own = next((path for path in (root / name / "__init__.py", root / f"{name}.py") if path.is_file()), None)
    loaded = getattr(sys.modules.get(name), "__file__", None)
    if own is not None and loaded is not None and Path(loaded).resolve() != own:
        raise UserError(
            f"{own}: a module {name!r} was already loaded from {loaded}; give it a name of its own,"
            f" for example my_{name}"
        )
