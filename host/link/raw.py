"""Raw frames opened: what navigation took in (`firmware.link.raw_frames`), and copies of its memory."""

from __future__ import annotations

from typing import Any, NamedTuple

from firmware.link.raw_frames import INPUTS, RAW_STATE, RAW_WANTED, SLICE_HEAD, WANTED


class RawInput(NamedTuple):
    """One input; `values` as the layout of its kind has them behind the number."""

    kind: int
    number: int
    values: tuple[Any, ...]


class RawSlice(NamedTuple):
    """A part of a copy of the memory as it was before input `number`."""

    number: int
    place: int
    places: int
    data: bytes


class RawWanted(NamedTuple):
    """A loop that is fed asks for the input `number`."""

    number: int


def open_raw(kind: int, payload: bytes) -> RawInput | RawSlice | RawWanted | None:
    """The message in a raw frame's payload; None when its type or length is not known."""
    layout = INPUTS.get(kind)
    if layout is not None:
        if len(payload) != layout.size:
            return None
        number, *values = layout.unpack(payload)
        return RawInput(kind, number, tuple(values))
    if kind == RAW_STATE and len(payload) > SLICE_HEAD.size:
        number, place, places = SLICE_HEAD.unpack_from(payload)
        return RawSlice(number, place, places, payload[SLICE_HEAD.size :])
    if kind == RAW_WANTED and len(payload) == WANTED.size:
        return RawWanted(*WANTED.unpack(payload))
    return None
