"""Where boards are found: by path, in a repository outside, among installed packages, or beside this file.

A package outside this repository names its boards as entry points, the value being the package that holds
the `board.toml`:

    [project.entry-points."navtwin.boards"]
    tilt = "tilt"

Installed, such a board is found by its name. Not installed, it is found by the path of its folder or of the
repository whose `pyproject.toml` says so.
"""

from __future__ import annotations

import tomllib
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec
from pathlib import Path

from boards.validation import DescriptionError

ENTRY_POINT_GROUP = "navtwin.boards"
_HERE = Path(__file__).parent


def board_names() -> list[str]:
    """The boards that come with navtwin and those that installed packages name, in alphabetical order."""
    return sorted({*_own_names(), *(point.name for point in entry_points(group=ENTRY_POINT_GROUP))})


def board_folder(name_or_path: str) -> Path:
    """The folder of a board given by name, by folder, by its board.toml or by its repository.

    A path goes before a name. Raises DescriptionError that tells what there is.
    """
    path = Path(name_or_path)
    if path.name == "board.toml" and path.is_file():
        return path.parent
    if (path / "board.toml").is_file():
        return path
    if name_or_path in _own_names():
        return _HERE / name_or_path
    in_repository = _boards_of_repository(path) if (path / "pyproject.toml").is_file() else {}
    if len(in_repository) == 1:
        return next(iter(in_repository.values()))
    if in_repository:
        folders = ", ".join(str(folder) for folder in in_repository.values())
        raise DescriptionError(f"{path} holds {len(in_repository)} boards; name the folder of one: {folders}")
    for point in entry_points(group=ENTRY_POINT_GROUP, name=name_or_path):
        return _installed_folder(point)
    known = ", ".join(board_names())
    raise DescriptionError(
        f"no board {name_or_path!r}: not a folder with a board.toml; boards by name: {known}"
    )


def _own_names() -> list[str]:
    return [entry.name for entry in _HERE.iterdir() if (entry / "board.toml").is_file()]


def _installed_folder(point: EntryPoint) -> Path:
    """The folder of the package that an entry point names. The package is found, not imported."""
    try:
        spec = find_spec(point.module)
    except (ImportError, ValueError):
        spec = None
    for folder in (spec.submodule_search_locations or ()) if spec is not None else ():
        if (Path(folder) / "board.toml").is_file():
            return Path(folder)
    raise DescriptionError(
        f"board {point.name!r}: its entry point names {point.value!r}, which is not an installed package"
        f' with a board.toml; for example [project.entry-points."{ENTRY_POINT_GROUP}"] tilt = "tilt"'
    )


def _boards_of_repository(root: Path) -> dict[str, Path]:
    """Boards that the pyproject.toml of a repository names, below it or below its src; name → folder."""
    try:
        project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8")).get("project", {})
        named = project.get("entry-points", {}).get(ENTRY_POINT_GROUP, {})
        packages = {str(name): str(value).partition(":")[0].split(".") for name, value in named.items()}
    except (OSError, ValueError, AttributeError):
        return {}
    return {
        name: place.joinpath(*parts)
        for name, parts in packages.items()
        for place in (root, root / "src")
        if (place.joinpath(*parts) / "board.toml").is_file()
    }
