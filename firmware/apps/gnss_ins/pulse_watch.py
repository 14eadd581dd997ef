"""Is the receiver's time pulse still there? Told when it fails and when it is back.

Navigation goes on without it, with epochs dated by their bursts; but a line that fell silent is a defect.
"""

from __future__ import annotations

from typing import Final

from firmware.apps.gnss_ins.output import Output
from firmware.apps.gnss_ins.parts import Receiver
from firmware.drivers import gnss_epoch as gnss
from hal.machine_code import mypyc_attr

LOOKS: Final = 3
"""Epochs in a row that agree."""


@mypyc_attr(allow_interpreted_subclasses=True)
class PulseWatch:
    """Looked at once a second or more often, from the background."""

    def __init__(self, receiver: Receiver, output: Output) -> None:
        self._receiver = receiver
        self._output = output
        self._was_there = False
        self._is_lost = False
        self._looks = 0
        self._epochs = 0

    def look(self) -> None:
        """Say what has changed."""
        receiver = self._receiver
        if receiver.epochs == self._epochs:
            return
        self._epochs = receiver.epochs
        self._was_there |= receiver.pulse_dated
        located = receiver.latest[gnss.FLAGS] & gnss.HAS_POSITION
        lost = bool(self._was_there and located and not receiver.pulse_dated)
        self._looks = 0 if lost == self._is_lost else self._looks + 1
        if self._looks == LOOKS:
            self._is_lost, self._looks = lost, 0
            self._output.send_text("time pulse lost" if lost else "time pulse is back")
