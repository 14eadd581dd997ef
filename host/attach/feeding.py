"""Raw frames for a board that has no sensors of its own: what is sent when, and again when it was lost.

The board tells every input again when it has taken it, in order. So many bytes may be on their way as its
ring holds; what it does not tell within PATIENCE_S is sent again, and at once when it asks (WANTED).
"""

from __future__ import annotations

from collections.abc import Sequence

from firmware.link.frames import FrameWriter
from firmware.link.raw_frames import INPUTS, RAW_START
from host.link.raw import RawInput, RawWanted, open_raw

WINDOW_BYTES = 1200
PATIENCE_S = 0.5
AGAIN_S = 0.1
"""A question that was just answered is not answered again."""

Input = tuple[int, bytes]
"""Kind and payload of a raw frame."""


def inputs_in_order(frames: Sequence[Input]) -> list[Input]:
    """The inputs among frames, from the first START as far as none is missing."""
    found: list[Input] = []
    expected = -1
    for kind, payload in frames:
        if kind not in INPUTS or len(payload) != INPUTS[kind].size:
            continue
        number = _number(payload)
        if kind == RAW_START:
            expected = 0
        if number != expected:
            if found:
                break
            continue
        found.append((kind, payload))
        expected = (number + 1) & 0xFFFF_FFFF
    return found


class Feeding:
    """Inputs on their way to a board; times are s of any clock that rises."""

    def __init__(self, inputs: Sequence[Input]) -> None:
        self.taken = 0
        """Inputs that the board has told again."""
        self.repeated = 0
        """Inputs that were sent more than once."""
        self.progress_s = 0.0
        """When the last one was taken."""
        self._inputs = inputs
        self._writer = FrameWriter()
        self._next = self._furthest = 0
        self._bytes = 0
        self._asked: tuple[int, float] = (-1, 0.0)
        self._waits_since_s = 0.0

    @property
    def is_done(self) -> bool:
        """Whether the board has taken all."""
        return self.taken == len(self._inputs)

    def hear(self, kind: int, payload: bytes, now_s: float) -> None:
        """A frame of the board."""
        message = open_raw(kind, payload)
        if isinstance(message, RawInput):
            self._told(kind, message.number, now_s)
        elif isinstance(message, RawWanted):
            self._wanted(message.number, now_s)

    def due(self, now_s: float) -> list[bytes]:
        """Frames to send now."""
        if now_s - self._waits_since_s > PATIENCE_S and self._next > self.taken:
            self._go_back(self.taken, now_s)
        frames = []
        while self._next < len(self._inputs) and self._bytes < WINDOW_BYTES:
            frame = self._writer.frame(*self._inputs[self._next])
            frames.append(frame)
            self._bytes += len(frame)
            self.repeated += self._next < self._furthest
            self._next += 1
            self._furthest = max(self._furthest, self._next)
        return frames

    def unsent(self, frames: int) -> None:
        """So many of those that were due last did not go."""
        self._next -= frames
        self._bytes = self._bytes_of(self.taken, self._next)

    def _told(self, kind: int, number: int, now_s: float) -> None:
        for place in range(self.taken, self._next):
            told, payload = self._inputs[place]
            if told == kind and _number(payload) == number:
                self._take_until(place + 1, now_s)
                return

    def _wanted(self, number: int, now_s: float) -> None:
        place = self._place_of(number)
        if place is None or (place == self._asked[0] and now_s - self._asked[1] < AGAIN_S):
            return
        self._asked = (place, now_s)
        if place > self.taken:
            self._take_until(place, now_s)
        if place < self._next:
            self._go_back(place, now_s)

    def _place_of(self, number: int) -> int | None:
        """Of the input that the board wants; of 0 the latest START, as it has lost all."""
        if number:
            places = range(self.taken, self._next + 1)
            sent = (at for at in places if at < len(self._inputs) and _number(self._inputs[at][1]) == number)
            return next(sent, None)
        return next((at for at in range(min(self._next, len(self._inputs) - 1), -1, -1)
                     if self._inputs[at][0] == RAW_START), None)  # fmt: skip

    def _take_until(self, place: int, now_s: float) -> None:
        self._bytes -= self._bytes_of(self.taken, place)
        self.taken = place
        self.progress_s = self._waits_since_s = now_s

    def _go_back(self, place: int, now_s: float) -> None:
        self.taken = min(self.taken, place)
        self._next = place
        self._bytes = self._bytes_of(self.taken, place)
        self._waits_since_s = now_s

    def _bytes_of(self, begin: int, end: int) -> int:
        return sum(len(payload) + 7 for _, payload in self._inputs[begin:end])


def _number(payload: bytes) -> int:
    return int.from_bytes(payload[:4], "little")
