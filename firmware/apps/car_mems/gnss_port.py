"""The receiver's port: bytes from the DMA ring become epochs, epochs become filter updates.

gnss_receive (interrupt of the port)  parse what has arrived, date a finished epoch
filter (task)                         one Kalman update
service (background)                  power, configuration, silence behind a burst
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from firmware.apps.car_mems.gnss_time import GnssTime
from firmware.apps.car_mems.navigation import Navigation
from firmware.apps.car_mems.settings import Settings
from firmware.drivers import gnss_epoch as gnss
from firmware.drivers.neo_m8n import Configurator, Phase, ReceiverSetup
from firmware.drivers.receiver_stream import ReceiverStream
from hal.board_io import BoardIo

POWER_ON_BAUD = 9600
FAST_BAUD = 115_200
QUIET_LOOKS = 2
"""Looks of the background at a silent port: the silence ends a burst, after that there is nothing to see."""


class GnssPort:
    """Owns the port, the time pulse and the epoch that waits for the filter."""

    def __init__(self, io: BoardIo, settings: Settings, navigation: Navigation) -> None:
        self.stream = ReceiverStream(baud=POWER_ON_BAUD)
        self.time = GnssTime()
        self._epoch = gnss.new_epoch()
        """The epoch that the filter works on or has used last."""
        self.latest: list[int] = self._epoch.tolist()
        """The same for the output."""
        self._waiting = gnss.new_epoch()
        """The latest epoch, dated; the filter takes it when its turn comes."""
        self.epochs_skipped = 0
        """Epochs that another one overtook before the filter's turn."""
        self._is_waiting = False
        self.epochs = 0
        self.port_errors = 0
        """Framing errors and overruns of the port since it runs."""
        self.pulse_dated = False
        self._pulse = (0, 0)
        """Count and time of the edge known when the waiting epoch was dated."""
        self._uart = io.uart["gnss"]
        self._clock = io.clock
        self._cpu = io.cpu
        self._parse_cost = io.cpu.cost("parse_byte")
        self._pulse_cost = io.cpu.cost("timepulse")
        self._update_cost = io.cpu.cost("filter_update")
        self._navigation = navigation
        self._parsed = 0
        self._quiet_looks = 0
        self._enable = io.outputs["gnss_enable"]
        self._line = io.interrupts.attach("gnss_receive", self._on_bytes)
        self._filter = io.interrupts.attach("filter", self._on_epoch)
        self._capture = io.captures.get("timepulse")
        if self._capture is not None:
            self._capture.start(io.interrupts.attach("timepulse", self._on_pulse))
        self.updated = _nobody
        """Called in the filter task after each update."""
        self._configurator = Configurator(self._uart, self.stream, _setup(settings))

    def begin(self) -> None:
        """Listen, then switch the receiver on."""
        self._uart.start_receive(self.stream.ring, self._line)
        self._enable.set(True)

    @property
    def phase(self) -> Phase:
        """How far the set-up of the receiver is."""
        return self._configurator.phase

    def service(self) -> None:
        """From the background: next step of the configuration; a silence ends a burst."""
        self._configurator.step(self._clock.now_ns())
        errors = self._uart.take_errors()
        if self._configurator.phase is Phase.RUNNING:
            self.port_errors += errors
        if self._quiet_looks < QUIET_LOOKS:
            self._quiet_looks += 1
            self._line.pend()

    def absorb(self, epoch: NDArray[np.int64], pulse: tuple[int, int]) -> None:
        """The filter takes a dated epoch."""
        self._epoch[:] = epoch
        self.latest = self._epoch.tolist()
        self._navigation.take_epoch(self._epoch, pulse)

    def _on_pulse(self) -> None:
        assert self._capture is not None
        self.time.take_pulse(*self._capture.captured())
        self._cpu.spend(self._pulse_cost)

    def _on_bytes(self) -> None:
        now_ns = self._clock.now_ns()
        received = self._uart.received()
        if received > self._parsed:
            self._cpu.spend(self._parse_cost * (received - self._parsed))
            self._parsed = received
            self._quiet_looks = 0
        while self.stream.take(received, now_ns):
            self._date_epoch()

    def _date_epoch(self) -> None:
        epoch = self._waiting
        epoch[:] = self.stream.epoch
        burst_start_ns = int(epoch[gnss.BURST_START_NS])
        valid_ns, self.pulse_dated = self.time.validity(int(epoch[gnss.TIME_OF_DAY_MS]), burst_start_ns)
        epoch[gnss.VALID_NS] = valid_ns
        self._pulse = self.time.edge
        self.epochs += 1
        self.epochs_skipped += self._is_waiting
        self._is_waiting = True
        self._filter.pend()

    @property
    def epoch(self) -> NDArray[np.int64]:
        """The record that the filter took last."""
        return self._epoch

    def _on_epoch(self) -> None:
        self._is_waiting = False
        self.absorb(self._waiting, self._pulse)
        self._cpu.spend(self._update_cost)
        self.updated()


def _setup(settings: Settings) -> ReceiverSetup | None:
    """What the receiver is configured to; None: left as it comes."""
    if settings.receiver == "nmea-default":
        return None
    return ReceiverSetup(baud=FAST_BAUD, rate_hz=settings.gnss_rate_hz)


def _nobody() -> None:
    pass
