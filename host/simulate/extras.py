"""Libraries that only some commands need."""

from __future__ import annotations

from importlib.util import find_spec

from host.record.errors import UserError


def must_have(module: str, command: str, remedy: str = "pip install 'navtwin[sim]'") -> None:
    """Raises UserError that tells how to install what is missing."""
    if find_spec(module) is None:
        raise UserError(f"{command} needs {module}, which is not installed: {remedy}")
