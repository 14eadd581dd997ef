"""What is asked of a replay."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from host.record.result import Progress

REPLAY_FORMAT = "navtwin-replay-1"


@dataclass(frozen=True, slots=True)
class ReplayRequest:
    """One replay. None: as recorded."""

    capture: Path
    board: str | None = None
    profile: str | None = None
    out_dir: Path | None = None
    """Of a physical replay: where its own capture and report go; None: nothing is written."""
    progress: Progress | None = None
    notice: Callable[[str], None] | None = None
    overrides: tuple[str, ...] = ()
    """Of a physical replay: further changes, as given to --set."""
