"""The error of a wrong scenario."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


class ScenarioError(ValueError):
    """A scenario is wrong. The message names file, key, offending value and a valid example."""


@contextmanager
def named(path: Path | None, name: str) -> Iterator[None]:
    """What is wrong below gets the scenario's file in front, or its name where it came from none."""
    try:
        yield
    except ScenarioError as error:
        raise ScenarioError(f"{path or name}: {error}") from None
