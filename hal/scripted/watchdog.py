"""A scripted watchdog."""

from hal.scripted.transcript import Transcript


class ScriptedWatchdog:
    """Implements `hal.watchdog.Watchdog`: `watchdog start NS`, `watchdog kick`."""

    def __init__(self, transcript: Transcript) -> None:
        self._transcript = transcript

    def start(self, timeout_ns: int) -> None:
        """A step."""
        self._transcript.take(f"watchdog start {timeout_ns}")

    def kick(self) -> None:
        """A step."""
        self._transcript.take("watchdog kick")
