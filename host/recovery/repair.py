"""A capture that was cut off, made whole: with the rows that were missing, and an index for other tools."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path

from host.capture.copying import CaptureCopy
from host.record.atomic import made_aside
from host.record.errors import UserError
from host.recovery.whole_reader import WholeReader


def repair(source: Path, target: Path) -> WholeReader:
    """Write `source`, which a crash or a kill cut off, to `target`; the reader tells what was added.

    Raises UserError, also for a capture that is whole.
    """
    if target.exists():
        raise UserError(f"-o {target}: exists already; name a new file")
    reader = WholeReader(source)
    copy: CaptureCopy | None = None
    with made_aside(target, "-o") as part, ExitStack() as opened:
        for message in reader.messages():
            if copy is None:
                copy = CaptureCopy(opened.enter_context(part.open("wb")), reader, {"repaired": True})
            copy.take(message)
        if copy is None:
            raise UserError(f"capture {source}: it was cut off before anything was recorded")
        if reader.summary is not None or (reader.complete and not reader.added):
            raise UserError(f"capture {source}: it is whole; there is nothing to be repaired")
        copy.finish()
    return reader
