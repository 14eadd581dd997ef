"""The receiver's port: bytes from the DMA ring become epochs, dated by the time pulse where there is one.

gnss_receive (interrupt of the port)  parse what has arrived, date a finished epoch
timepulse (capture)                   note the edge
service (background)                  configuration, silence behind a burst
"""

from __future__ import annotations

from typing import Final, Protocol

from firmware.apps.gnss_ins.gnss_time import GnssTime
from firmware.drivers import gnss_epoch as gnss
from firmware.drivers.receiver_stream import ReceiverStream
from firmware.drivers.satellite_lists import SatelliteInView
from hal.board_io import BoardIo
from hal.machine_code import mypyc_attr

QUIET_LOOKS: Final = 2
"""Looks of the background at a silent port: the silence ends a burst, after that there is nothing to see."""


class Configurator(Protocol):
    """Who sets the receiver up."""

    def step(self, now_ns: int) -> None:
        """Look at what was heard, send what is due."""
        ...


@mypyc_attr(allow_interpreted_subclasses=True)
class ReceiverPort:
    """Owns the port, the time pulse and the latest epoch. What becomes of an epoch a part says in `_dated`,
    and whether the receiver is set up in `is_running`."""

    def __init__(self, io: BoardIo, stream: ReceiverStream) -> None:
        self.stream = stream
        self.time = GnssTime()
        self.waiting = gnss.new_epoch()
        """The latest epoch, dated."""
        self.epochs = 0
        self.port_errors = 0
        self.pulse_dated = False
        self.pulse = (0, 0)
        """Count and time of the edge known when that epoch was dated."""
        self.uart = io.uart["gnss"]
        self._clock = io.clock
        self._cpu = io.cpu
        self._parse_cost = io.cpu.cost("parse_byte")
        self._pulse_cost = io.cpu.cost("timepulse")
        self._parsed = 0
        self._quiet_looks = 0
        self._line = io.interrupts.attach("gnss_receive", self._on_bytes)
        self._capture = io.captures.get("timepulse")
        if self._capture is not None:
            self._capture.start(io.interrupts.attach("timepulse", self._on_pulse))

    @property
    def is_running(self) -> bool:
        """Whether the receiver is set up."""
        raise NotImplementedError

    def _dated(self) -> None:
        """`waiting` holds a new epoch."""
        raise NotImplementedError

    def listen(self) -> None:
        """Receive from now on."""
        self.uart.start_receive(self.stream.ring, self._line)

    def serve(self, configurator: Configurator) -> None:
        """From the background: next step of the configuration; a silence ends a burst."""
        configurator.step(self._clock.now_ns())
        errors = self.uart.take_errors()
        if self.is_running:
            self.port_errors += errors
        if self._quiet_looks < QUIET_LOOKS:
            self._quiet_looks += 1
            self._line.pend()

    def line_errors(self) -> tuple[int, int]:
        """(messages with a wrong check sum, bytes of garbage) so far."""
        return self.stream.line_errors()

    def satellites(self) -> list[SatelliteInView]:
        """Satellites in view as listed last."""
        return self.stream.satellites()

    def _on_pulse(self) -> None:
        assert self._capture is not None
        self.time.take_pulse(*self._capture.captured())
        self._cpu.spend(self._pulse_cost)

    def _on_bytes(self) -> None:
        now_ns = self._clock.now_ns()
        received = self.uart.received()
        if received > self._parsed:
            self._cpu.spend(self._parse_cost * (received - self._parsed))
            self._parsed = received
            self._quiet_looks = 0
        while self.stream.take(received, now_ns):
            self._date_epoch()

    def _date_epoch(self) -> None:
        epoch = self.waiting
        epoch[:] = self.stream.epoch
        burst_start_ns = int(epoch[gnss.BURST_START_NS])
        valid_ns, self.pulse_dated = self.time.validity(int(epoch[gnss.TIME_OF_DAY_MS]), burst_start_ns)
        epoch[gnss.VALID_NS] = valid_ns
        self.pulse = self.time.edge
        self.epochs += 1
        self._dated()
