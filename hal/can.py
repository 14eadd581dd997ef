"""CAN 2.0 controller, classic frames with 11- or 29-bit identifiers and 0 … 8 data bytes."""

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import repeat
from typing import Any, NamedTuple, Protocol, overload

SET_FRAME_BYTES = 8


class CanFrame(NamedTuple):
    """One data frame."""

    identifier: int
    data: bytes
    extended: bool = False


_frame_of_fields: Any = partial(tuple.__new__, CanFrame)
"""`CanFrame._make` for fields that are known to be three."""


class CanSet(Sequence[CanFrame]):
    """Frames of eight bytes with 11-bit identifiers that are sent together, their data in one piece.

    A sequence of frames for everybody who wants to look at one; a controller may take it as it is.
    """

    __slots__ = ("data", "identifiers")

    def __init__(self, identifiers: tuple[int, ...], data: bytes) -> None:
        if len(data) != SET_FRAME_BYTES * len(identifiers):
            raise ValueError(
                f"a set of {len(identifiers)} CAN frames has {len(data)} data bytes; it needs"
                f" {SET_FRAME_BYTES} for each"
            )
        self.identifiers = identifiers
        self.data = data

    def __len__(self) -> int:
        return len(self.identifiers)

    def __iter__(self) -> Iterator[CanFrame]:
        data = self.data
        fields = [data[at : at + SET_FRAME_BYTES] for at in range(0, len(data), SET_FRAME_BYTES)]
        return map(_frame_of_fields, zip(self.identifiers, fields, repeat(False)))

    @overload
    def __getitem__(self, index: int) -> CanFrame: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[CanFrame, ...]: ...
    def __getitem__(self, index: int | slice) -> CanFrame | tuple[CanFrame, ...]:
        return tuple(self)[index]


class CanController(Protocol):
    """One node on one bus."""

    def send(self, frames: Sequence[CanFrame]) -> int:
        """Queue frames in order and return how many were taken; the rest found the queue full."""
        ...

    def receive(self) -> CanFrame | None:
        """The oldest frame received, or None."""
        ...
