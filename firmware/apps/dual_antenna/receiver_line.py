"""The receiver's RS-232 line: its set-up, its sentences, its epochs for the DSP."""

from __future__ import annotations

from firmware.apps.dual_antenna.memory_map import PULSE_DATED
from firmware.apps.dual_antenna.post import Post
from firmware.apps.gnss_ins.receiver_port import ReceiverPort
from firmware.drivers.dual_antenna import BAUD_RATES, DualAntennaSetup
from firmware.drivers.receiver_stream import ReceiverStream
from firmware.drivers.sentence_setup import SentenceConfigurator, SetupPhase
from hal.board_io import BoardIo

PHASES = tuple(SetupPhase)
WORD, SHORT = 0xFFFF_FFFF, 0xFFFF
SENTENCES = {"GGA": 1, "RMC": 1, "GST": 1, "PTNL,AVR": 1}
"""AVR has heading and tilt when ambiguities are fixed, and the length of the baseline."""


class ReceiverLine(ReceiverPort):
    """Owns the receiver's port."""

    def __init__(self, io: BoardIo, post: Post) -> None:
        super().__init__(io, ReceiverStream(baud=BAUD_RATES[0]))
        self._post = post
        self._configurator = SentenceConfigurator(
            self.uart, self.stream, DualAntennaSetup(rates_hz=SENTENCES)
        )

    @property
    def is_running(self) -> bool:
        """Whether the receiver is set up."""
        return self._configurator.phase is SetupPhase.RUNNING

    def service(self) -> None:
        """From the background."""
        self.serve(self._configurator)

    def health(self) -> tuple[int, int, int, int]:
        """Phase and pulse, bad check sums, bytes of garbage, errors of the port so far."""
        bad, garbage = self.line_errors()
        phase = PHASES.index(self._configurator.phase)
        return (
            phase | PULSE_DATED * self.pulse_dated,
            bad & WORD,
            garbage & WORD,
            self.port_errors & WORD,
        )

    def _dated(self) -> None:
        self._post.epoch(self.waiting.tobytes())
