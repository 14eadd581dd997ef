"""What the FPGA measures in settings mode: the seven chips at 200 Hz as in acquisition, the compass at 10 Hz.

It sends no packets: whoever collects hangs on `each_tick`.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from firmware.apps.gfsins.accelerations import CHIPS, fill_accelerations
from firmware.apps.gfsins.accelerometers import Accelerometers
from firmware.apps.gfsins.compass_line import CompassLine
from firmware.apps.gfsins.corrections import Corrections
from firmware.apps.gfsins.receiver_line import ReceiverLine
from firmware.nav.gyro_free import packet as pk
from firmware.numerics.dialect import entry_point
from hal.board_io import BoardIo

TICKS_PER_MEAN = 100
LOOKS_WITHOUT = 5
SIGN = 0x8000


class Sampling:
    """Owns the sensors in settings mode. `tick` is the timer's interrupt, `look` comes ten times a second."""

    def __init__(self, io: BoardIo, corrections: Corrections) -> None:
        self.ticks = 0
        self.chips = Accelerometers(io)
        self.words = np.zeros(pk.WORDS, np.int64)
        """ACCELERATIONS holds the nine of the tick, scaled and offset."""
        self.compass = CompassLine(io)
        self.receiver = ReceiverLine(io)
        self.each_tick: Callable[[int], None] | None = None
        """Called in the interrupt with the tick's time (ns) when `words` are filled."""
        self.means = [0.0] * 9
        """Of the nine over the last half second, in words of 0.5 mg: for people to read."""
        self._sums = np.zeros(9, np.int64)
        self._raw = np.frombuffer(self.chips.raw, np.uint8)
        self._corrections = corrections
        self._fill = entry_point(fill_accelerations)
        self._looks = 0
        self._clock = io.clock
        self._cpu = io.cpu
        self._cost = io.cpu.cost("tick")

    def begin(self) -> None:
        """Bring up what can be brought up before the timer runs; takes some milliseconds."""
        for chip in range(CHIPS):
            self.chips.start(chip)
        self.receiver.listen()

    def tick(self) -> None:
        """Nine accelerations."""
        tick_ns = self._clock.now_ns()
        self.ticks += 1
        self.chips.drain()
        corrections = self._corrections
        self._fill(self._raw, corrections.scales, corrections.offsets, self.words)
        self._add_up()
        each_tick = self.each_tick
        if each_tick is not None:
            each_tick(tick_ns)
        self._cpu.spend(self._cost)

    def _add_up(self) -> None:
        self._sums += (self.words[pk.ACCELERATIONS : pk.ACCELERATIONS + 9] ^ SIGN) - SIGN
        if self.ticks % TICKS_PER_MEAN == 0:
            self.means = (self._sums / TICKS_PER_MEAN).tolist()
            self._sums[:] = 0

    def look(self) -> None:
        """The compass, and the receiver's set-up. A compass that is missing is looked for less often than in
        acquisition: that takes half a second, in which the operator waits."""
        self._looks += 1
        if self.compass.works or self._looks % LOOKS_WITHOUT == 0:
            self.compass.look()
        self.receiver.service()

    def mend(self) -> None:
        """Bring up what is missing, once a second."""
        for chip in range(CHIPS):
            if self.chips.missing >> chip & 1:
                self.chips.start(chip)
