"""The GR-87 at the FPGA: its set-up, and its sentences by DMA; an epoch waits for the next packet."""

from __future__ import annotations

from firmware.apps.gnss_ins.receiver_port import ReceiverPort
from firmware.drivers.gr87 import BAUD_RATES, Gr87Setup
from firmware.drivers.receiver_stream import ReceiverStream
from firmware.drivers.sentence_setup import SentenceConfigurator, SetupPhase
from hal.board_io import BoardIo
from hal.machine_code import mypyc_attr

PHASES = tuple(SetupPhase)


@mypyc_attr(allow_interpreted_subclasses=True)
class ReceiverLine(ReceiverPort):
    """Owns the receiver's port."""

    def __init__(self, io: BoardIo) -> None:
        super().__init__(io, ReceiverStream(baud=BAUD_RATES[0]))
        self.is_fresh = False
        """`waiting` has not been put into a packet yet."""
        setup = Gr87Setup(periods_s={"GGA": 1, "RMC": 1})
        self._configurator = SentenceConfigurator(self.uart, self.stream, setup)

    @property
    def is_running(self) -> bool:
        """Whether the receiver is set up."""
        return self._configurator.phase is SetupPhase.RUNNING

    @property
    def phase(self) -> int:
        """How far its set-up is."""
        return PHASES.index(self._configurator.phase)

    def service(self) -> None:
        """From the background."""
        self.serve(self._configurator)

    def _dated(self) -> None:
        self.is_fresh = True
