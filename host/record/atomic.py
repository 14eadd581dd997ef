"""Files and folders that are there whole or not at all: written aside and renamed."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from host.record.errors import UserError


def refuse_device(path: Path, option: str = "") -> None:
    """Raise UserError for what is there and is no file, whose place a file would take: a device, a pipe."""
    stands_for_one = path.is_symlink() and path.parent == Path("/dev")
    if stands_for_one or (path.exists() and not path.is_file() and not path.is_dir()):
        where = f"{option} {path}" if option else str(path)
        raise UserError(
            f"{where}: is a device or pipe, no file; name a file, for example result{path.suffix}"
        )


def write_whole(path: Path, content: str | bytes, option: str = "") -> None:
    """Write a file so that nobody ever sees half of it.

    Raises UserError that names the file, and the command-line `option` that asked for it.
    """
    refuse_device(path, option)
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


@contextmanager
def made_aside(target: Path, option: str) -> Iterator[Path]:
    """A path beside a new file or folder, which gets the target's name when all went well.

    A target that is an empty folder is filled. Whatever goes wrong, nothing stays behind. Raises UserError
    that names the target and the command-line `option`.
    """
    refuse_device(target, option)
    whole = target.resolve()
    part = whole.with_name(f"{whole.name}.{os.getpid()}.part")
    try:
        try:
            yield part
            if target.is_dir() and part.is_dir():
                for made in part.iterdir():
                    made.replace(target / made.name)
                part.rmdir()
            elif part.exists():
                part.replace(target)
        except OSError as error:
            raise UserError(f"{option} {target}: cannot be written: {error.strerror}") from None
    finally:
        if part.is_dir():
            shutil.rmtree(part, ignore_errors=True)
        else:
            part.unlink(missing_ok=True)
