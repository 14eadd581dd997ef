"""What is known of a board by what it said last; of bounded size whatever it says and for however long."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

from firmware.drivers.gnss_epoch import HAS_HEIGHT, HAS_POSITION
from firmware.drivers.satellite_lists import SatelliteInView
from firmware.link import frames
from firmware.nav.flags import DEGRADED, NAVIGATING
from host.link.messages import (
    Bias,
    Gnss,
    Innovation,
    Message,
    Satellites,
    Sensor,
    Solution,
    Status,
    TaskFigures,
    Tasks,
)
from host.monitor.recorded import Attitude, Inertial
from host.monitor.track import Track

EVENTS_KEPT = 200
INNOVATIONS_KEPT = 120
TASKS_KEPT = 64
SATELLITES_KEPT = 256
RESTART_US = 1_000_000
"""Board time that goes back by more than this is another start of the board."""
US = 1e-6
WRAP = 1 << 32

Shown = Message | Inertial | Attitude
"""What the view can take."""


@dataclass(frozen=True, slots=True)
class Event:
    """Something said in words, at a time of the source in s."""

    at_s: float
    text: str


@dataclass(frozen=True, slots=True)
class TaskLoad:
    """A task and the share of the processor that it took between the last two reports (None: one only)."""

    figures: TaskFigures
    time_us: int
    load: float | None


class BoardState:
    """Takes messages of `host.link`, keeps the latest of each kind and short histories."""

    def __init__(self) -> None:
        self.solution: Solution | None = None
        self.gnss: Gnss | None = None
        self.sensor: Sensor | None = None
        """How the inertial sensor is, where a board tells."""
        self.status: Status | None = None
        self.bias: Bias | None = None
        self.innovation: Innovation | None = None
        self.innovations: deque[Innovation] = deque(maxlen=INNOVATIONS_KEPT)
        self.inertial: Inertial | None = None
        self.attitude: Attitude | None = None
        """Both of recordings without a board's solution."""
        self.satellites: tuple[SatelliteInView, ...] | None = None
        """None: no list was sent so far."""
        self.tasks: dict[str, TaskLoad] = {}
        self.run_tasks: tuple[TaskLoad, ...] = ()
        """Of a whole run that is played, where its record tells them."""
        self.events: deque[Event] = deque(maxlen=EVENTS_KEPT)
        self.track = Track()
        self.board_us = 0
        """Latest time of the board's clock."""
        self.restarts = 0
        self.at_s = 0.0
        """Source time of the latest message."""
        self.seen_s: dict[int, float] = {}
        """Kind of frame → source time of the latest one."""
        self.fix_name: str | None = None
        """The receiver's own word for its fix, where it was read directly."""
        self._list: list[SatelliteInView] = []
        self._list_next = 0

    def take(self, kind: int, message: Shown, at_s: float) -> None:
        """One message that came at `at_s`, s of the source's clock."""
        self.at_s = at_s
        self.seen_s[kind] = at_s
        match message:
            case Solution():
                self.seen_s[frames.SOLUTION] = at_s  # whichever frame held it
                self._note_time(message.time_us)
                self.solution = message
                self._track_solution(message)
            case Status():
                self._note_time(message.time_us)
                self.status = message
            case Sensor():
                self._note_time(message.time_us)
                self.sensor = message
            case Gnss():
                self._take_gnss(message)
            case Bias():
                self.bias = message
            case Innovation():
                self.innovation = message
                self.innovations.append(message)
            case Inertial() | Attitude():
                self._take_recorded(message)
            case Satellites():
                self._take_satellites(message)
            case Tasks():
                for figures in message.tasks:
                    self._take_task(figures, message.time_us)
            case str() if kind == frames.TEXT:
                self.say(message)

    def say(self, text: str) -> None:
        """An event in words; what a terminal would obey is taken out of it."""
        words = "".join(sign if sign.isprintable() else "·" for sign in text)
        self.events.append(Event(self.at_s, words))

    @property
    def is_navigating(self) -> bool:
        """Whether the solution means something."""
        return self.solution is not None and self.solution.mode in (NAVIGATING, DEGRADED)

    @property
    def fix(self) -> str:
        """The receiver's fix in words."""
        if self.gnss is None:
            return "-"
        if not self.gnss.flags & HAS_POSITION:
            return "no fix"
        return self.fix_name or ("3D" if self.gnss.flags & HAS_HEIGHT else "2D")

    def _note_time(self, time_us: int) -> None:
        if time_us + RESTART_US < self.board_us:
            self.restarts += 1
            self.tasks.clear()
            self.say("board clock went back: the board has started again")
        self.board_us = time_us

    def _track_solution(self, solution: Solution) -> None:
        if self.is_navigating:
            yaw = solution.yaw if math.isfinite(solution.yaw) else 0.0
            self.track.add_fused(solution.lat_nanodeg, solution.lon_nanodeg, yaw)

    def _take_gnss(self, epoch: Gnss) -> None:
        self.gnss = epoch
        if epoch.flags & HAS_POSITION:
            self.track.add_gnss(epoch.lat_nanodeg, epoch.lon_nanodeg)

    def _take_recorded(self, message: Inertial | Attitude) -> None:
        if isinstance(message, Attitude):
            self.attitude = message
        else:
            self.inertial = message.completed_from(self.inertial)

    def _take_satellites(self, part: Satellites) -> None:
        """Parts come in order; a list with a part missing is not shown."""
        if part.number == 0:
            self._list = []
            self._list_next = 0
        if part.number != self._list_next:
            self._list_next = -1
            return
        self._list += part.satellites
        self._list_next += 1
        if self._list_next == part.frames:
            self.satellites = tuple(self._list[:SATELLITES_KEPT])
            self._list = []
            self._list_next = -1

    def _take_task(self, figures: TaskFigures, time_us: int) -> None:
        before = self.tasks.get(figures.name)
        if before is None and len(self.tasks) >= TASKS_KEPT:
            return
        load = None
        if before is not None and time_us > before.time_us:
            busy_us = (figures.busy_us - before.figures.busy_us) % WRAP
            load = busy_us / (time_us - before.time_us)
        self.tasks[figures.name] = TaskLoad(figures, time_us, load)
