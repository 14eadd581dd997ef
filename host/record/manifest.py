"""The manifest of a run: all that is needed to run it again, and to tell what ran."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from typing import Any

MANIFEST_FORMAT = "navtwin-run-1"

PACKAGES = ("navtwin", "numpy", "numba", "greenlet")
"""What the figures of a run depend on."""


def build_manifest(
    board: str,
    board_text: str,
    scenario: str,
    scenario_text: str,
    profile: str,
    seed: int,
    overrides: Sequence[str] = (),
) -> dict[str, Any]:
    """Manifest of a run that is about to begin. The texts are those of board.toml and the scenario file."""
    return {
        "format": MANIFEST_FORMAT,
        "board": board,
        "scenario": scenario,
        "profile": profile,
        "seed": seed,
        "overrides": list(overrides),
        "versions": versions(),
        "machine": platform.machine(),
        "board_text": board_text,
        "scenario_text": scenario_text,
    }


def versions() -> dict[str, str]:
    """Of Python and of the packages that figures depend on."""
    return {"python": platform.python_version(), **{name: _version(name) for name in PACKAGES}}


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "unknown"
