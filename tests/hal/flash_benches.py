"""Benches of the checks for flash memories: on virtual time, and on a transcript."""

from __future__ import annotations

from scripted_benches import GrowingTranscript

from hal.emulated.cpu import EmulatedCpu
from hal.emulated.flash import EmulatedFlash
from hal.emulated.virtual_time import VirtualTime
from hal.scripted import ScriptedFlash


class EmulatedFlashBench:
    def __init__(self) -> None:
        self.flash = EmulatedFlash(EmulatedCpu(VirtualTime(), "mcu", 100_000_000), "settings")

    def expect(self, action: str, reply: str = "") -> None:
        pass


class ScriptedFlashBench:
    def __init__(self) -> None:
        self._script = GrowingTranscript()
        self.flash = ScriptedFlash(self._script, "settings")

    def expect(self, action: str, reply: str = "") -> None:
        self._script.add(f"{action} -> {reply}" if reply else action)
