"""The program of the DSP: rate from nine accelerometers, filters side by side, what the host is told.

packet (SPI, DMA) ─► navigation ─► output                    main: status by I²C, health, words, watchdog
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from firmware.apps.gfsins.acquisition_news import AcquisitionNews
from firmware.apps.gfsins.background import Background
from firmware.apps.gfsins.filter_frames import FilterFrames
from firmware.apps.gfsins.flight import Flight
from firmware.apps.gfsins.navigation import Navigation, filter_config
from firmware.apps.gfsins.reception import Reception
from firmware.apps.gfsins.sensor_flags import SensorFlags
from firmware.apps.gfsins.settings import Settings
from firmware.apps.gfsins.solver import Solver
from firmware.apps.gfsins.words import Words
from firmware.apps.gnss_ins.announcements import Announcer
from firmware.apps.gnss_ins.navigation import StateKernels
from firmware.apps.gnss_ins.output import Output
from hal.board_io import BoardIo


def program(io: BoardIo, profile: Mapping[str, Any], installation: Mapping[str, Any]) -> Navigator:
    """The image in flash. Raises ValueError for a profile or installation that no program could mean."""
    return Navigator(io, Settings.of(profile), installation)


class Navigator:
    """Implements `hal.board_io.Program`."""

    def __init__(self, io: BoardIo, settings: Settings, installation: Mapping[str, Any]) -> None:
        self._io = io
        self._settings = settings
        self._kernels = StateKernels("float32")
        self._config = filter_config(settings, installation)
        self._navigation: Navigation | None = None

    def main(self) -> None:
        """From the reset vector: nothing survives a reset."""
        io, settings = self._io, self._settings
        navigation = Navigation(self._kernels, self._config)
        self._navigation = navigation
        reception = Reception(io)
        news = AcquisitionNews(io, reception, navigation.door.epoch.tolist)
        output = Output(
            io, navigation, news, news, port=io.uart["host"], clock=io.clock, task_frames=settings.task_frames
        )
        uses_registers = settings.feed == "adxl345"
        sensor_flags = SensorFlags(io.clock, reception, news, navigation.federation.n, uses_registers)
        navigation.flags_of = sensor_flags.of
        flight = Flight(io, settings, navigation, reception, news, output, sensor_flags)
        words = Words(navigation, reception, news, output)
        solver = Solver(io, self._config.sensor, output.send_text)
        reception.other = solver.on_packet
        announcer = Announcer(io.clock, news, output)
        filters = FilterFrames(io, navigation, self._kernels, output)
        background = Background(io, news, output, announcer, words, flight, solver, filters)
        output.send_text("navigation begins: waiting for packets")
        flight.begin()
        background.run()

    def spoil(self) -> None:
        """Leave NaN in the velocity, as a defective kernel would."""
        if self._navigation is not None:
            self._navigation.spoil()

    def memory(self) -> bytes:
        """The filters as they lie in memory."""
        return b"" if self._navigation is None else self._navigation.memory()
