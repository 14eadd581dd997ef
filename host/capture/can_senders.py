"""CAN records that tell their senders (`host.capture.blocks`), made of records that do not."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any

import numpy as np

from hal.emulated.can_bursts import HeardFrame, HeardSets
from host.capture.blocks import CAN_HEAD, FULL_CAN_RECORD, SENT_CAN_HEAD, WORTH_ARRAYS

LONGEST_NAME = 255
KEPT_BLANKS = 16


def with_senders(records: bytes, heard: Sequence[HeardFrame]) -> bytes:
    """`records` (`blocks.can_records`) of the frames `heard`, each with the name of its sender."""
    if not heard:
        return b""
    if isinstance(heard, HeardSets):
        told = _blank_sets(len(heard), _encoded(heard.sender), heard.set_identifiers)
        told["end_ns"] = heard.ends_ns
        told["data"] = np.frombuffer(heard.data, "S8")
        return bytes(told.tobytes())
    names = {name for _frame, _end, name in heard}
    if (
        len(names) == 1
        and len(heard) >= WORTH_ARRAYS
        and len(records) == FULL_CAN_RECORD.itemsize * len(heard)
    ):
        return _of_one_sender(np.frombuffer(records, FULL_CAN_RECORD), _encoded(names.pop()))
    place = 0
    pieces = []
    for frame, _end, name in heard:
        end_ns, identifier, n = CAN_HEAD.unpack_from(records, place)
        place += CAN_HEAD.size + n
        sender = _encoded(name)
        pieces.append(SENT_CAN_HEAD.pack(end_ns, identifier, n, len(sender)) + frame.data + sender)
    return b"".join(pieces)


@functools.cache
def _encoded(name: str) -> bytes:
    return name.encode()[:LONGEST_NAME]


@functools.cache
def _dtype(length: int) -> np.dtype[np.void]:
    fields: list[Any] = [*FULL_CAN_RECORD.descr]
    fields.insert(3, ("s", "u1"))
    return np.dtype([*fields, ("sender", f"S{length}")] if length else fields)


def _of_one_sender(records: Any, sender: bytes) -> bytes:
    told = _blank(len(records), sender)
    for name in ("end_ns", "identifier", "data"):
        told[name] = records[name]
    return told.tobytes()


@functools.lru_cache(KEPT_BLANKS)
def _blank_sets(count: int, sender: bytes, identifiers: tuple[int, ...]) -> Any:
    """The same with identifiers, of sets with these."""
    blank = _blank(count, sender).copy()
    blank["identifier"] = np.resize(identifiers, count)
    return blank


@functools.lru_cache(KEPT_BLANKS)
def _blank(count: int, sender: bytes) -> Any:
    """Records in which only length and sender stand; whoever gets them writes all the rest."""
    blank = np.empty(count, _dtype(len(sender)))
    blank["n"] = 8
    blank["s"] = len(sender)
    if sender:
        blank["sender"] = sender
    return blank
