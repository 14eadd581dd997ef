"""Puts a board together from its description: processors, buses, chips and wires on one virtual time.

What the board is wired to outside (the world its sensors feel, the host at the other end of a UART) is
given by the caller through `Surroundings`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any, Protocol

from boards.chips.world import GnssWorld, ImuWorld
from boards.description import Board, Chip
from boards.machine import Machine
from hal.board_io import BoardIo
from hal.emulated.can import EmulatedCanBus, EmulatedCanController
from hal.emulated.cpu import EmulatedCpu
from hal.emulated.interrupt_line import LineSpec
from hal.emulated.pins import EmulatedInputPin, EmulatedOutputPin, Net
from hal.emulated.spi import EmulatedSpiBus
from hal.emulated.storage import EmulatedLogFile
from hal.emulated.timers import EmulatedCaptureTimer, EmulatedPeriodicTimer
from hal.emulated.uart import EmulatedUart, UartWire
from hal.emulated.watchdog import EmulatedWatchdog


class Surroundings(Protocol):
    """What lies outside the board."""

    def imu(self, refdes: str, chip: Chip) -> ImuWorld:
        """What the inertial chip `refdes` feels."""
        ...

    def gnss(self, refdes: str, chip: Chip) -> GnssWorld:
        """What the receiver `refdes` sees."""
        ...

    def log_sink(self, name: str) -> Callable[[bytes], None]:
        """Where the blocks of the log file `name` go."""
        ...
