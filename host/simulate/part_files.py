"""Several files that belong together: they appear all at once when all are whole, or not at all."""

from __future__ import annotations

import contextlib
import tempfile
from pathlib import Path
from types import TracebackType
from typing import IO, BinaryIO, Self

from host.record.atomic import refuse_device
from host.record.errors import UserError


class PartFiles:
    """Files written aside as NAME.part. Leaving the `with` block in peace gives them their names.

    Raises UserError, which names --output, when one cannot be written.
    """

    def __init__(self, keep: Path | None = None) -> None:
        """`keep`: what is read, whose place none of them may take."""
        self._keep = None if keep is None else keep.resolve()
        self._open: list[tuple[Path, BinaryIO]] = []
        self._asides = contextlib.ExitStack()

    def open(self, path: Path) -> BinaryIO:
        """A new one, for binary writing."""
        if path.resolve() == self._keep:
            raise UserError(
                f"-o: would write {path}, which is the file that is read; name another one,"
                f" for example -o new-{path.name}"
            )
        refuse_device(path, "-o")
        part = path.with_name(path.name + ".part")
        try:
            file = part.open("wb")
        except OSError as error:
            raise UserError(f"-o {path}: cannot be written: {error.strerror}") from None
        self._open.append((path, file))
        return file

    def aside(self, path: Path) -> IO[bytes]:
        """A nameless file for what is written into the one at `path` later; it goes with the `with` block."""
        try:
            return self._asides.enter_context(tempfile.TemporaryFile(dir=path.parent))
        except OSError as error:
            raise UserError(f"-o {path}: cannot be written: {error.strerror}") from None

    @property
    def paths(self) -> list[Path]:
        """The files, by their final names."""
        return [path for path, _file in self._open]

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, _trace: TracebackType | None
    ) -> None:
        try:
            for _path, file in self._open:
                file.close()
            if kind is None:
                for path, _file in self._open:
                    path.with_name(path.name + ".part").replace(path)
        except OSError as failed:
            self._remove()
            raise self._told(failed) from None
        finally:
            with contextlib.suppress(OSError):  # a full disk: what is in their buffers is not wanted
                self._asides.close()
            if kind is not None:
                self._remove()
        if isinstance(error, OSError):
            raise self._told(error) from None

    def _told(self, error: OSError) -> UserError:
        place = self._open[0][0] if self._open else ""
        return UserError(f"-o {place}: cannot be written: {error.strerror}; nothing was kept")

    def _remove(self) -> None:
        for path, file in self._open:
            if not file.closed:
                with contextlib.suppress(OSError):  # a full disk: what is in its buffer is not wanted
                    file.close()
            path.with_name(path.name + ".part").unlink(missing_ok=True)
