"""Files that are there whole or not at all: written aside and renamed."""

from __future__ import annotations

from pathlib import Path

from host.record.errors import UserError


def write_whole(path: Path, content: str | bytes, option: str = "") -> None:
    """Write a file so that nobody ever sees half of it.

    Raises UserError that names the file, and the command-line `option` that asked for it.
    """
    data = content.encode() if isinstance(content, str) else content
    part = path.with_name(path.name + ".part")
    try:
        part.write_bytes(data)
        part.replace(path)
    except OSError as error:
        if part.is_file():
            part.unlink()
        where = f"{option} {path}" if option else str(path)
        raise UserError(f"{where}: cannot be written: {error.strerror}") from None
