"""What the DSP knows of the acquisition: packets, and once a second its status over I²C."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from firmware.apps.gfsins import commands
from firmware.apps.gfsins.reception import Reception
from firmware.drivers.hmc6343 import Outcome as CompassOutcome
from firmware.drivers.satellite_lists import SatelliteInView
from firmware.drivers.sentence_setup import SetupPhase
from hal.board_io import BoardIo
from hal.errors import BusError

PATIENCE = 3
MARKS = (commands.MARK, commands.SETTINGS_MARK)
PHASES = tuple(SetupPhase)
COMPASS_OUTCOMES = tuple(CompassOutcome)


class AcquisitionNews:
    """Implements `Receiver` and `Sensor` of `firmware.apps.gnss_ins.parts`."""

    def __init__(self, io: BoardIo, reception: Reception, latest: Callable[[], list[int]]) -> None:
        self.epochs = 0
        self.missing = 0
        self.stuck = 0
        self.at_odds = 0
        self.compass = 0
        self.unanswered = 0
        """Times in a row that the FPGA did not answer."""
        self.starts = 0
        self.port_errors = 0
        self.pulse_dated = False
        self.unsent = 0
        self.in_settings = False
        """Whether the FPGA is in settings mode: it sends no packets of measurements."""
        self._bus = io.command_buses["commands"]
        self._reception = reception
        self._latest = latest
        self._phase = 0

    def ask(self) -> None:
        """Read its status; takes 1.1 ms. One that is spoilt is none."""
        try:
            data = self._bus.transaction(commands.ADDRESS, b"", commands.STATUS_BYTES)
        except BusError:
            self.unanswered += 1
            return
        told = commands.open_status(data)
        if told is None or told[0] not in MARKS:
            self.unanswered += 1
            return
        self.unanswered = 0
        mark, self.starts, self.missing, self.stuck, self.at_odds, *rest = told
        self.compass, self._phase, self.port_errors, self.unsent = rest
        self.in_settings = mark == commands.SETTINGS_MARK
        if self.in_settings:
            self._tell_presence()

    def _tell_presence(self) -> None:
        """An operator at the FPGA wants to know whether anybody solves."""
        try:
            self._bus.transaction(commands.ADDRESS, bytes((commands.PRESENT,)))
        except BusError:
            self.unanswered += 1

    def tell_alignment(self, yaw: float, pitch: float, roll: float) -> None:
        """The result, in radians."""
        tenths = (round(angle * 572.9577951308232) for angle in (yaw, pitch, roll))
        try:
            self._bus.transaction(commands.ADDRESS, commands.RESULT.pack(commands.ALIGNED, *tenths))
        except BusError:
            self.unanswered += 1

    @property
    def answers(self) -> bool:
        """Whether the FPGA can be asked; it has some seconds to begin."""
        return self.unanswered < PATIENCE

    @property
    def compass_words(self) -> str:
        """How the compass is."""
        return COMPASS_OUTCOMES[self.compass % len(COMPASS_OUTCOMES)].value

    @property
    def latest(self) -> list[int]:
        """The epoch that came last."""
        return self._latest()

    @property
    def reads(self) -> int:
        """Packets that came."""
        return self._reception.good

    @property
    def phase_name(self) -> str:
        """How far the set-up of the receiver is."""
        return PHASES[self._phase % len(PHASES)].value

    @property
    def is_running(self) -> bool:
        """Whether it is set up."""
        return PHASES[self._phase % len(PHASES)] is SetupPhase.RUNNING

    def line_errors(self) -> tuple[int, int]:
        """Of the receiver's line, which is the FPGA's: it tells the errors of its port alone."""
        return 0, 0

    def satellites(self) -> Sequence[SatelliteInView]:
        """It is asked for no list."""
        return ()
