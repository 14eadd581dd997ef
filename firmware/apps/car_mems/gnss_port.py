"""The receiver's epochs on their way to the filter.

gnss_receive, timepulse               see `firmware.apps.gnss_ins.receiver_port`
filter (task)                         one Kalman update
service (background)                  power, configuration
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from firmware.apps.car_mems.navigation import Navigation
from firmware.apps.car_mems.settings import Settings
from firmware.apps.gnss_ins.receiver_port import ReceiverPort
from firmware.drivers import gnss_epoch as gnss
from firmware.drivers.neo_m8n import Configurator, Phase, ReceiverSetup
from firmware.drivers.receiver_stream import ReceiverStream
from hal.board_io import BoardIo
from hal.machine_code import mypyc_attr

POWER_ON_BAUD: Final = 9600
FAST_BAUD: Final = 115_200


@mypyc_attr(allow_interpreted_subclasses=True)
class GnssPort(ReceiverPort):
    """Owns the receiver and the epoch that waits for the filter."""

    def __init__(self, io: BoardIo, settings: Settings, navigation: Navigation) -> None:
        super().__init__(io, ReceiverStream(baud=POWER_ON_BAUD))
        self._epoch = gnss.new_epoch()
        """The epoch that the filter works on or has used last."""
        self.latest: list[int] = self._epoch.tolist()
        """The same for the output."""
        self.epochs_skipped = 0
        """Epochs that another one overtook before the filter's turn."""
        self._is_waiting = False
        self._update_cost = io.cpu.cost("filter_update")
        self._navigation = navigation
        self._enable = io.outputs["gnss_enable"]
        self._filter = io.interrupts.attach("filter", self._on_epoch)
        self.updated = _nobody
        """Called in the filter task after each update."""
        self._configurator = Configurator(self.uart, self.stream, _setup(settings))

    def begin(self) -> None:
        """Listen, then switch the receiver on."""
        self.listen()
        self._enable.set(True)

    @property
    def phase_name(self) -> str:
        """How far the set-up of the receiver is."""
        return self._configurator.phase.value

    @property
    def is_running(self) -> bool:
        """Whether it is set up."""
        return self._configurator.phase is Phase.RUNNING

    def service(self) -> None:
        """From the background."""
        self.serve(self._configurator)

    def absorb(self, epoch: NDArray[np.int64], pulse: tuple[int, int]) -> None:
        """The filter takes a dated epoch."""
        self._epoch[:] = epoch
        self.latest = self._epoch.tolist()
        self._navigation.take_epoch(self._epoch, pulse)

    @property
    def epoch(self) -> NDArray[np.int64]:
        """The record that the filter took last."""
        return self._epoch

    def _dated(self) -> None:
        self.epochs_skipped += self._is_waiting
        self._is_waiting = True
        self._filter.pend()

    def _on_epoch(self) -> None:
        self._is_waiting = False
        self.absorb(self.waiting, self.pulse)
        self._cpu.spend(self._update_cost)
        self.updated()


def _setup(settings: Settings) -> ReceiverSetup | None:
    """What the receiver is configured to; None: left as it comes."""
    if settings.receiver == "nmea-default":
        return None
    return ReceiverSetup(baud=FAST_BAUD, rate_hz=settings.gnss_rate_hz)


def _nobody() -> None:
    pass
