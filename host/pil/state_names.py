"""Names of the elements of state arrays, read off the layout module beside the kernel that uses them."""

from __future__ import annotations

import ast
import functools
import importlib
import importlib.util
import sys
from pathlib import Path

SIZE = "_SIZE"


def state_name(module: str, array: str, index: int) -> str | None:
    """The constant at or before `index` of `array` ("f", "i", "s") and how far behind it, `U + 12`.

    Looked for in the layout of the package `module` lies in, or that it imports; None where there is none.
    """
    for layout in _layouts(module):
        for name, at, end in _constants(layout).get(array, ()):
            if at <= index < end:
                return name if index == at else f"{name} + {index - at}"
    return None


def _layouts(module: str) -> list[str]:
    """Modules called layout that the kernel's module names, its own package's first."""
    loaded = sys.modules.get(module) or importlib.import_module(module)
    own = f"{module.rpartition('.')[0]}.layout"
    tree = ast.parse(Path(str(loaded.__file__)).read_text(encoding="utf-8"))
    found = [own] if importlib.util.find_spec(own) is not None else []
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module:
            found += [f"{node.module}.layout" for name in node.names if name.name == "layout"]
    return list(dict.fromkeys(found))


@functools.cache
def _constants(layout: str) -> dict[str, list[tuple[str, int, int]]]:
    """For each array (first element, behind the last one) of each name; F_SIZE, I_SIZE … end a section."""
    module = importlib.import_module(layout)
    tree = ast.parse(Path(str(module.__file__)).read_text(encoding="utf-8"))
    arrays: dict[str, list[tuple[str, int, int]]] = {}
    section: list[tuple[int, str]] = []
    for node in tree.body:
        target = node.targets[0] if isinstance(node, ast.Assign) else getattr(node, "target", None)
        if not isinstance(target, ast.Name) or not isinstance(getattr(module, target.id, None), int):
            continue
        value = int(getattr(module, target.id))
        if target.id.endswith(SIZE) and len(target.id) == 1 + len(SIZE):
            arrays[target.id[0].lower()] = _spans(section, value)
            section = []
        else:
            section.append((value, target.id))
    return arrays


def _spans(section: list[tuple[int, str]], size: int) -> list[tuple[str, int, int]]:
    """Names that grow from one to the next; what stands out of order (numbers of states) is not a place."""
    places: list[tuple[int, str]] = []
    for value, name in reversed(section):
        if value < (places[-1][0] if places else size):
            places.append((value, name))
        if value == 0 and places and places[-1][0] == 0:
            break
    places.reverse()
    ends = [at for at, _ in places[1:]] + [size]
    return [(name, at, end) for (at, name), end in zip(places, ends, strict=True)]
