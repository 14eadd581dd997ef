"""Supply, start and navigation epochs of a receiver; each part builds on it.

Time line of a start: the supply comes, `boot_ns` later the port is up, then follows one epoch after the
other on a grid of the satellites' time. At each the world is asked for the epoch valid now, and what the
part makes of it is shown when the world's latency has passed. A pause of the supply or a reset ends the
session: whatever was under way is lost.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import partial
from typing import ClassVar, Generic, TypeVar

from boards.chips.receivers.transmitter import Transmitter
from boards.chips.registers import AccessLog, AccessReport, ReportKind
from boards.chips.world import GnssEpoch, GnssWorld
from hal.emulated.pins import Net
from hal.emulated.virtual_time import Event, VirtualTime

START_STATES = ("cold", "warm", "hot")
Shown = TypeVar("Shown")
"""What a receiver makes of an epoch and shows."""


class Receiver(ABC, Generic[Shown]):
    """One receiver. A part says what it does at a start, makes something of an epoch, and shows it."""

    feels = "gnss"
    """The world that it asks."""
    boot_ns: ClassVar[int]
    """From the supply or a reset until the port is up."""

    def __init__(
        self, time: VirtualTime, world: GnssWorld, transmitter: Transmitter, name: str, *, strict: bool
    ) -> None:
        self.name = name
        self.pins: dict[str, Net | None] = {}
        self.log = AccessLog(name, strict=strict)
        self._time = time
        self._world = world
        self._transmitter = transmitter
        self._powered = self._running = False
        self._session = 0
        self._started_ns = 0
        self._off_since_ns: int | None = None
        self._next_epoch: Event | None = None
        self._shown: Shown | None = None
        """What was shown last."""

    @property
    def reports(self) -> list[AccessReport]:
        """What the host said wrongly, and what it asked for that this model leaves out."""
        return self.log.reports

    @property
    def baud(self) -> int:
        """Bit rate of the port now, both directions; 0 before the first start."""
        return self._transmitter.baud

    @property
    def messages_dropped(self) -> int:
        """Messages that found no room in the transmit buffer."""
        return self._transmitter.dropped

    # -- what a part does --------------------------------------------------------------------------

    @abstractmethod
    def receive(self, data: bytes, time_ns: int) -> None:
        """Bytes from the host, complete at `time_ns`."""

    def _wake(self, off_ns: int) -> None:
        """The supply is back after a pause: what is left? Default: as at the first start."""

    @abstractmethod
    def _begin(self) -> None:
        """A start begins, the port is not up yet."""

    @abstractmethod
    def _start_port(self, epoch: GnssEpoch) -> None:
        """The port comes up; `epoch` is valid now."""

    @abstractmethod
    def _solve(self, epoch: GnssEpoch, now_ns: int) -> Shown:
        """What it makes of the epoch that is valid now."""

    @abstractmethod
    def _show(self, solution: Shown) -> None:
        """Output of an epoch begins."""

    @abstractmethod
    def _epoch_after(self, epoch: GnssEpoch) -> int:
        """Virtual time of the next epoch; `epoch` tells what time it is now."""

    # -- supply and start --------------------------------------------------------------------------

    def power(self, on: bool) -> None:
        """Switch the supply."""
        if on == self._powered:
            return
        self._powered = on
        if not on:
            self._halt()
            self._off_since_ns = self._time.now
            return
        if self._off_since_ns is not None:
            self._wake(self._time.now - self._off_since_ns)
        self._boot()

    def _boot(self) -> None:
        self._session += 1
        self._started_ns = self._time.now
        self._begin()
        self._time.at(self._time.now + self.boot_ns, partial(self._come_up, self._session))

    def _come_up(self, session: int) -> None:
        if session == self._session:
            self._running = True
            epoch = self._world.epoch(self._time.now)
            self._start_port(epoch)
            self._next_epoch = self._time.at(self._epoch_after(epoch), self._navigate)

    def _halt(self) -> None:
        """Supply or reset: everything under way is lost."""
        self._session += 1
        self._running = False
        if self._next_epoch is not None:
            self._next_epoch.cancel()
            self._next_epoch = None
        self._transmitter.stop()

    def _reset(self) -> None:
        self._halt()
        self._boot()

    # -- epochs ------------------------------------------------------------------------------------

    def _navigate(self) -> int:
        """One epoch; returns when the next one is."""
        now = self._time.now
        epoch = self._world.epoch(now)
        solution = self._solve(epoch, now)
        if epoch.latency_ns > 0:
            self._time.at(now + epoch.latency_ns, partial(self._display, solution, self._session))
        else:
            self._display(solution, self._session)
        return self._epoch_after(epoch)

    def _display(self, solution: Shown, session: int) -> None:
        if session == self._session:
            self._shown = solution
            self._show(solution)

    def _on_grid(self, satellite_time_ns: int, period_ns: int, nearest_ns: int) -> int:
        """Virtual time of the next multiple of the period in `satellite_time_ns`, which it is now; at least
        `nearest_ns` ahead, so that a jitter of the world's clock repeats no epoch."""
        step = period_ns - satellite_time_ns % period_ns
        return self._time.now + (step if step >= nearest_ns else step + period_ns)

    def _report(self, kind: ReportKind, what: str, detail: str) -> None:
        self.log.report(kind, what, detail, self._time.now)


def check_start_state(name: str, start_state: str) -> None:
    """Raises ValueError, as a model's parameters do."""
    if start_state not in START_STATES:
        raise ValueError(f"{name}: start_state = {start_state!r}; possible: 'cold', 'warm', 'hot'")
