"""Which names a new board may have: it names a Python package and an entry point too."""

from __future__ import annotations

import keyword
import re
import sys
from importlib.util import find_spec

from boards.places import board_names
from host.record.errors import UserError

PATTERN = re.compile(r"[a-z][a-z0-9_]*")
LONGEST = 40
ROOMS = ("navtwin", "hal", "firmware", "boards", "host", "tests", "ci", "build")
"""navtwin and its packages, and folders of the skeleton."""


def check_name(name: str) -> None:
    """Raises UserError for a name that no board can have, with one that would do."""
    if PATTERN.fullmatch(name) is None:
        raise UserError(
            f"board name {name!r}: must be lower-case letters, digits and _, a letter first;"
            f" for example {_suggested(name)}"
        )
    if len(name) > LONGEST:
        raise UserError(f"board name {name!r}: {len(name)} characters, at most {LONGEST}; for example tilt")
    if name in board_names():
        raise UserError(f"board name {name!r}: there is a board of that name; for example my_{name}")
    if keyword.iskeyword(name) or name in ROOMS or name in sys.stdlib_module_names or _is_installed(name):
        raise UserError(f"board name {name!r}: Python or navtwin uses that name; for example my_{name}")


def _is_installed(name: str) -> bool:
    try:
        spec = find_spec(name)
    except (ImportError, ValueError):
        return True
    return spec is not None and spec.origin is not None


def _suggested(name: str) -> str:
    plain = re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_0123456789")[:LONGEST]
    return plain if PATTERN.fullmatch(plain) else "tilt"
