"""What the front end tells of its lines ten times a second, and the board clock that it keeps."""

from __future__ import annotations

from collections.abc import Sequence

from firmware.apps.dual_antenna import memory_map as at
from firmware.apps.dual_antenna.exchange import Exchange
from firmware.drivers.satellite_lists import SatelliteInView
from firmware.drivers.sentence_setup import SetupPhase
from hal.board_io import BoardIo

PHASES = tuple(SetupPhase)


class BoardClock:
    """The front end's clock, as it was told last and went on since by the DSP's. Implements
    `hal.clock.Clock`."""

    def __init__(self, io: BoardIo) -> None:
        self._clock = io.clock
        self._ahead_ns = 0

    def hear(self, board_ns: int) -> None:
        """The front end's clock shows that now."""
        self._ahead_ns = board_ns - self._clock.now_ns()

    def now_ns(self) -> int:
        """Time since the front end's reset."""
        return max(0, self._clock.now_ns() + self._ahead_ns)


class FrontEndNews:
    """Implements `Receiver` and `Sensor` of `firmware.apps.gnss_ins.parts` at the DSP."""

    def __init__(self, io: BoardIo, exchange: Exchange) -> None:
        self.clock = BoardClock(io)
        self.starts = 0
        """Of the front end."""
        self.is_silent = True
        """Its clock did not go on since the last look."""
        self.imu_errors = (0, 0, 0, 0, 0)
        """Of the inertial unit's line: lost samples, bad frames, garbage, overruns, errors of the port."""
        self.port_errors = 0
        self.pulse_dated = False
        self._memory = io.memories["exchange"]
        self._exchange = exchange
        self._clock_ns = 0
        self._line_errors = (0, 0)
        self._phase = SetupPhase.LISTENING
        self.look()

    def look(self) -> None:
        """Read what it wrote last."""
        told = at.HEALTH.unpack(self._memory.read(at.HEALTH_AT, at.HEALTH_WORDS))
        clock_ns, self.starts, _frames, *imu, phase, bad, garbage, self.port_errors = told
        self.is_silent = clock_ns == self._clock_ns
        if not self.is_silent:
            self._clock_ns = clock_ns
            self.clock.hear(clock_ns)
        self.imu_errors = tuple(imu)
        self.pulse_dated = bool(phase & at.PULSE_DATED)
        self._phase = PHASES[(phase & at.PHASE_MASK) % len(PHASES)]
        self._line_errors = bad, garbage

    @property
    def latest(self) -> list[int]:
        """The epoch that the filter took last."""
        return self._exchange.latest

    @property
    def epochs(self) -> int:
        """Those that have come."""
        return self._exchange.epochs

    @property
    def reads(self) -> int:
        """Samples that have come."""
        return self._exchange.samples

    @property
    def phase_name(self) -> str:
        """How far the set-up of the receiver is."""
        return self._phase.value

    @property
    def is_running(self) -> bool:
        """Whether it is set up."""
        return self._phase is SetupPhase.RUNNING

    def line_errors(self) -> tuple[int, int]:
        """(messages with a wrong check sum, bytes of garbage) so far."""
        return self._line_errors

    def satellites(self) -> Sequence[SatelliteInView]:
        """It is asked for no list."""
        return ()
