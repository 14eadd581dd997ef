"""A board on a port that navigates on raw frames of a recording instead of sensors of its own."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from host.attach.board_source import CapturedBoard, Chunk, SerialBoard
from host.attach.feeding import Feeding, Input, inputs_in_order
from host.link.decoder import LinkDecoder
from host.record.errors import UserError
from host.run.intake import HOST_PORT

SILENCE_S = 10.0
"""Without progress; then the board does not listen."""
LINGER_S = 0.5
"""After the last input, for the solution behind it."""


class FedBoard(SerialBoard):
    """Ends when the board has taken all inputs. Raises UserError when it takes none for SILENCE_S."""

    def __init__(self, url: str, baud: int, inputs: Sequence[Input]) -> None:
        super().__init__(url, baud, baud)
        self._decoder = LinkDecoder()
        self._feeding = Feeding(inputs)
        self._inputs = len(inputs)

    def chunks(self) -> Iterator[Chunk]:
        """What the board says, while it is fed."""
        feeding = self._feeding
        for chunk in super().chunks():
            yield chunk
            now_s = self._now_ns() / 1e9
            for kind, payload in self._decoder.feed_raw(chunk.data) if chunk.data else ():
                feeding.hear(kind, payload, now_s)
            if feeding.is_done:
                if now_s - feeding.progress_s > LINGER_S:
                    return
                continue
            if now_s - feeding.progress_s > SILENCE_S:
                raise UserError(self._silence())
            self._feed(now_s)

    def figures(self) -> dict[str, Any]:
        """Of the line, and of what it was fed."""
        fed = {"inputs": self._inputs, "inputs_taken": self._feeding.taken,
               "inputs_repeated": self._feeding.repeated}  # fmt: skip
        return {**super().figures(), **fed}

    def _feed(self, now_s: float) -> None:
        frames = self._feeding.due(now_s)
        for place, frame in enumerate(frames):
            if not self.send(frame):
                self._feeding.unsent(len(frames) - place)
                return

    def _silence(self) -> str:
        taken = self._feeding.taken
        told = f"took {taken:,} of {self._inputs:,} inputs and then none" if taken else "takes no raw frames"
        return (
            f"{self.name}: the board {told} for {SILENCE_S:.0f} s; does it run an image of navtwin build,"
            f" and is its rate {self._link.baud} baud? (--baud N gives another one)"
        )


def inputs_of(path: Path, given: str) -> list[Input]:
    """The inputs in a capture. Raises UserError when there are none."""
    board = CapturedBoard(path, HOST_PORT)
    decoder = LinkDecoder()
    frames = [frame for chunk in board.chunks() for frame in decoder.feed_raw(chunk.data)]
    inputs = inputs_in_order([*frames, *decoder.finish_raw()])
    if not inputs:
        raise UserError(
            f"--feed {given}: holds no raw frames from a start on; record some, for example"
            " navtwin run car_mems --set profile.raw_output=true --out runs/fed"
        )
    return inputs
