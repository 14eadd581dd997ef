"""Names of the elements of state arrays, read off the layout module beside the kernel that uses them."""

from __future__ import annotations

import ast
import functools
import importlib
import importlib.util
import re
import sys
from pathlib import Path

SIZE = "_SIZE"
HEADING = re.compile(r"# --- \w\b")
"""Of the constants of one array, `# --- f: estimate ---`."""


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
    text = Path(str(module.__file__)).read_text(encoding="utf-8")
    tree = ast.parse(text)
    headings = [(number, line[6]) for number, line in enumerate(text.splitlines()) if HEADING.match(line)]
    arrays: dict[str, list[tuple[str, int, int]]] = {}
    section: list[tuple[int, int, str]] = []
    for node in tree.body:
        target = node.targets[0] if isinstance(node, ast.Assign) else getattr(node, "target", None)
        if not isinstance(target, ast.Name) or not isinstance(getattr(module, target.id, None), int):
            continue
        value = int(getattr(module, target.id))
        if target.id.endswith(SIZE) and len(target.id) == 1 + len(SIZE):
            array = target.id[0].lower()
            begin = min((number for number, heading in headings if heading == array), default=0)
            arrays[array] = _spans([(at, name) for line, at, name in section if line > begin], value)
            section = []
        else:
            section.append((node.lineno, value, target.id))
    return arrays


def _spans(section: list[tuple[int, str]], size: int) -> list[tuple[str, int, int]]:
    """(name, first, behind the last) of the places: the longest sequence of names, in the order of the
    source, whose numbers grow. What stands out of it (numbers of states, sizes) is no place."""
    lengths: list[int] = []
    before: list[int | None] = []
    for end, (value, _) in enumerate(section):
        best = max(
            (at for at in range(end) if section[at][0] < value),
            key=lambda at: (lengths[at], at),
            default=None,
        )
        before.append(best)
        lengths.append(1 if best is None else lengths[best] + 1)
    fitting = [at for at, (value, _) in enumerate(section) if value < size]
    at = max(fitting, key=lambda one: (lengths[one], one), default=None)
    spans: list[tuple[str, int, int]] = []
    while at is not None:
        value, name = section[at]
        spans.insert(0, (name, value, spans[0][1] if spans else size))
        at = before[at]
    return spans
