"""The arrays of kernels in the memory of the image, and what it takes to make them those of the twin."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from host.pil.monitor_link import ARRAY, READ, WRITE, MonitorLink
from host.record.errors import UserError

PIECE = 4096
LARGEST_ARRAY = 0xFFF8
MOST_HANDLES = 256
MOST_OF_A_KIND = 4
"""Arrays of one type and size; those that come and go share their places."""
GAP = 12
"""Unchanged bytes that are rather sent than skipped."""


@dataclass(slots=True)
class Place:
    """Where an array lies in the image's memory, and what it holds there."""

    handle: int
    offset: int
    array: NDArray[Any]
    """The twin's, which stands here now; keeping it keeps its identity."""
    held: NDArray[Any]
    """A copy; never changed, only replaced."""
    used: int = 0


class Mirror:
    """Places of arrays by their identity."""

    def __init__(self, link: MonitorLink, memory: int, flush: Callable[[], None]) -> None:
        """`memory`: bytes of the image; `flush` sends the calls that wait."""
        self._link = link
        self._memory = memory
        self._flush = flush
        self._free = 0
        self._handles = 0
        self._clock = 0
        self._by_identity: dict[int, Place] = {}
        self._by_kind: dict[tuple[str, int], list[Place]] = {}

    def place_of(self, array: NDArray[Any]) -> Place:
        """The place of an array, a new one if need be."""
        self._clock += 1
        place = self._by_identity.get(id(array))
        if place is None:
            place = self._new_place(array)
        place.used = self._clock
        return place

    def patches(self, place: Place) -> list[tuple[int, bytes]]:
        """(offset, bytes) that the twin's array has and the image has not, since it was held."""
        now, held = _bytes(place.array), _bytes(place.held)
        changed = np.flatnonzero(now != held)
        if changed.size == 0:
            return []
        runs = np.split(changed, np.flatnonzero(np.diff(changed) > GAP) + 1)
        return [(int(run[0]), now[run[0] : run[-1] + 1].tobytes()) for run in runs]

    def hold(self, place: Place) -> None:
        """The image now holds what the twin's array holds."""
        place.held = place.array.copy()

    def release(self) -> None:
        """The arrays to come are others; they take the places of those before, and what is equal stays."""
        self._by_identity.clear()
        for places in self._by_kind.values():
            for place in places:
                place.used = 0

    def has_room(self, sizes: Iterable[int]) -> bool:
        """Whether arrays of so many bytes fit behind those that have a place."""
        wanted = [-(-size // 8) * 8 for size in sizes]
        return self._free + sum(wanted) <= self._memory and self._handles + len(wanted) <= MOST_HANDLES

    def update(self, place: Place) -> None:
        """Bring what is not held into the image at once."""
        for at, data in self.patches(place):
            for begin in range(0, len(data), PIECE):
                part = data[begin : begin + PIECE]
                self._link.request(WRITE, struct.pack("<I", place.offset + at + begin) + part)

    def write(self, place: Place, values: NDArray[Any]) -> None:
        """Bring `values` into the image at once."""
        data = values.tobytes()
        for at in range(0, len(data), PIECE):
            self._link.request(WRITE, struct.pack("<I", place.offset + at) + data[at : at + PIECE])

    def read(self, place: Place) -> NDArray[Any]:
        """What the image holds."""
        size = place.held.nbytes
        wanted = [(place.offset + at, min(PIECE, size - at)) for at in range(0, size, PIECE)]
        parts = [self._link.request(READ, struct.pack("<IH", *one)) for one in wanted]
        return np.frombuffer(b"".join(parts), place.held.dtype)

    def _new_place(self, array: NDArray[Any]) -> Place:
        twin = self._of_same_memory(array)
        if twin is not None:
            place = self._define(array, twin.offset)
            same = self._by_kind[(twin.array.dtype.name, twin.array.size)]
            same[:] = [one for one in same if one is not twin]  # both keep their place for good
            self._by_identity[id(array)] = place
            return place
        same = self._by_kind.setdefault((array.dtype.name, array.size), [])
        oldest = min(same, key=lambda one: one.used, default=None)
        if oldest is not None and (oldest.used == 0 or len(same) >= MOST_OF_A_KIND):
            place = oldest
            self._by_identity.pop(id(place.array), None)
            place.array = array
        else:
            place = self._allocate(array)
            same.append(place)
        self._by_identity[id(array)] = place
        return place

    def _of_same_memory(self, array: NDArray[Any]) -> Place | None:
        """The place of another view of the whole of this array, as bytes and as numbers."""
        address, size = _address(array), array.nbytes
        views = (one for one in self._by_identity.values() if one.array.nbytes == size)
        return next((one for one in views if _address(one.array) == address), None)

    def _allocate(self, array: NDArray[Any]) -> Place:
        offset, size = self._free, array.nbytes
        self._free += -(-size // 8) * 8
        if self._free > self._memory or size > LARGEST_ARRAY:
            raise UserError(
                f"the kernels' arrays do not fit into the image's {self._memory} bytes:"
                f" {array.size} more of {array.dtype}"
            )
        return self._define(array, offset)

    def _define(self, array: NDArray[Any], offset: int) -> Place:
        handle, size = self._handles, array.nbytes
        if handle >= MOST_HANDLES:
            raise UserError(f"the kernels have more than {MOST_HANDLES} arrays")
        self._flush()
        self._handles += 1
        is_float = int(array.dtype == np.float32)
        self._link.request(ARRAY, struct.pack("<BBII", handle, is_float, offset, size))
        place = Place(handle, offset, array, array.copy())
        self.write(place, array)
        return place


def _address(array: NDArray[Any]) -> int:
    return int(array.__array_interface__["data"][0])


def _bytes(array: NDArray[Any]) -> NDArray[np.uint8]:
    return array.view(np.uint8)
