"""A stretch of a capture as a capture of its own."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

from host.capture.blocks import spans, time_of
from host.capture.copying import CaptureCopy
from host.capture.reader import CaptureReader, RawMessage
from host.record.atomic import made_aside
from host.record.errors import UserError

NS = 1_000_000_000
LONGEST_S = 1e9


def cut(reader: CaptureReader, target: Path, from_s: float, to_s: float) -> int:
    """Write what lies in [from_s, to_s) to `target`; returns the number of messages.

    The manifest says where it was cut; a capture cut at its end has no state hash any more. Raises UserError.
    """
    if not 0.0 <= from_s < to_s:
        raise UserError(
            f"--from {from_s:g} --to {to_s:g}: must be 0 or more and rise, e.g. --from 60 --to 120"
        )
    if target.exists():
        raise UserError(f"-o {target}: exists already; name a new file")
    copy: CaptureCopy | None = None
    to_s = min(to_s, LONGEST_S)
    begin_ns, end_ns = round(min(from_s, LONGEST_S) * NS), round(to_s * NS)
    with made_aside(target, "-o") as part, ExitStack() as opened:
        for message in reader.messages():
            if copy is None:
                until_s = min(to_s, reader.manifest.get("cut", {"to_s": to_s})["to_s"])
                where = {"cut": {"from_s": max(from_s, reader.cut_from_s), "to_s": until_s}}
                copy = CaptureCopy(opened.enter_context(part.open("wb")), reader, where)
            inside = _inside(message, begin_ns, end_ns)
            if inside is not None:
                copy.take(inside)
        if copy is None or not copy.messages:
            raise UserError(f"capture {reader.path}: nothing was recorded from {from_s:g} to {to_s:g} s")
        copy.mark(min(end_ns - 1, reader.end_ns or end_ns))
        copy.finish()
    return copy.messages


def _inside(message: RawMessage, begin_ns: int, end_ns: int) -> RawMessage | None:
    """What of a message lies in the stretch: records of a block by their own times."""
    if not message.is_raw:
        return message if begin_ns <= message.time_ns < end_ns else None
    kept = [
        (time_of(record), message.data[first:last])
        for record, first, last in spans(message.schema.name, message.topic, message.data)
        if begin_ns <= time_of(record) < end_ns
    ]
    if not kept:
        return None
    return replace(message, time_ns=kept[0][0], data=b"".join([piece for _, piece in kept]))
