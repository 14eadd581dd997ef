"""A scripted CAN controller."""

from collections import deque
from collections.abc import Sequence

from hal.can import CanFrame
from hal.scripted.transcript import Transcript, hex_words, to_bytes


class ScriptedCan:
    """Implements `hal.can.CanController`: `can NAME send ID BYTES`, `<- can NAME ID BYTES`."""

    def __init__(self, transcript: Transcript, name: str) -> None:
        self._transcript = transcript
        self.name = name
        self._received: deque[CanFrame] = deque()
        transcript.on_arrival("can", name, self._arrive)

    def send(self, frames: Sequence[CanFrame]) -> int:
        """A step for each frame, up to the first that finds the queue full."""
        for taken, frame in enumerate(frames):
            identifier = f"{frame.identifier:08x}x" if frame.extended else f"{frame.identifier:03x}"
            reply = self._transcript.take(
                f"can {self.name} send {identifier} {hex_words(frame.data)}".rstrip()
            )
            if reply == ("full",):
                return taken
        return len(frames)

    def receive(self) -> CanFrame | None:
        """The oldest frame received, or None."""
        self._transcript.play()
        return self._received.popleft() if self._received else None

    def _arrive(self, words: list[str]) -> None:
        identifier, *data = words
        extended = identifier.endswith("x")
        self._received.append(CanFrame(int(identifier.removesuffix("x"), 16), to_bytes(data), extended))
