"""A scripted log file."""

from hal.scripted.transcript import Transcript, hex_words


class ScriptedLog:
    """Implements `hal.storage.LogFile`: `log NAME append BYTES [-> failed]`, `log NAME sync [-> failed]`."""

    def __init__(self, transcript: Transcript, name: str) -> None:
        self._transcript = transcript
        self.name = name

    def append(self, data: bytes) -> bool:
        """A step; nothing to append is none."""
        return not data or self._transcript.take(f"log {self.name} append {hex_words(data)}") != ("failed",)

    def sync(self) -> bool:
        """A step."""
        return self._transcript.take(f"log {self.name} sync") != ("failed",)
