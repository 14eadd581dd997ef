"""Where the capture is that somebody means."""

from __future__ import annotations

from pathlib import Path

from host.record.errors import UserError

NAMES = ("run.mcap", "run.mcap.part")


def capture_path(given: Path) -> Path:
    """The file itself, or the one in the folder of a run (the provisional one of a run that was cut off)."""
    if given.is_dir():
        for name in NAMES:
            if (given / name).is_file():
                return given / name
        raise UserError(
            f"capture {given}: the folder holds no {NAMES[0]}; a run writes one without --no-capture"
        )
    if not given.exists() and (part := given.with_name(given.name + ".part")).is_file():
        raise UserError(
            f"capture {given}: no such file, but there is {part.name}: its run did not reach its end"
        )
    return given
