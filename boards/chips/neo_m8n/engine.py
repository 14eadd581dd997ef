"""The navigation engine: what the receiver knows when, after a cold, warm or hot start.

Fact sheet sections 1 and 7: no fix for 26 s after a cold start, about 1 s after a hot one, the time first
and a fix within a few seconds after a warm one; after a dropout the time is kept while the clock holds.
The world says where a fix is possible at all (outages, re-acquisition); the engine withholds it during a
start. Choices where the sheet gives no figure:

- cold: the time is known after 20 s (the first data frames), warm: fix after 5 s;
- the leap seconds are the firmware's default until they come from the sky: with the first fix that uses a
  GLONASS satellite (difference of the two system times), else 750 s after the first fix (the 12.5 min
  cycle of the GPS almanac);
- a course counts when the speed is at least 0.1 m/s and at least its own 1 σ accuracy, otherwise it is
  frozen (later u-blox manuals: "not calculated with sufficient accuracy or under 0.1 m/s").
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from boards.chips.neo_m8n.solution import FIX_2D, FIX_3D, NO_FIX, Solution
from boards.chips.receivers.fields import degrees, longitude_degrees
from boards.chips.receivers.utc import SECOND, WEEK_SECONDS, gps_week, utc_from_gps
from boards.chips.world import GnssEpoch, Satellite

StartState = Literal["cold", "warm", "hot"]

LOWEST_COURSE_SPEED = 0.1
LEAP_SECONDS_FROM_GPS_NS = 750 * SECOND
EPHEMERIS_AGE_NS = 2 * 3600 * SECOND
"""A receiver that was off for longer starts warm, not hot."""


@dataclass(frozen=True, slots=True)
class StartTimes:
    """When things become known after a start, ns, and whether the leap seconds survived it."""

    time_ns: int
    fix_ns: int
    leap_known: bool
    sky_known: bool


START_TIMES: dict[StartState, StartTimes] = {
    "cold": StartTimes(20 * SECOND, 26 * SECOND, leap_known=False, sky_known=False),
    "warm": StartTimes(0, 5 * SECOND, leap_known=True, sky_known=True),
    "hot": StartTimes(0, 1 * SECOND, leap_known=True, sky_known=True),
}

UNSET_CLOCK_NS = 1867 * WEEK_SECONDS * SECOND
"""GPS time at which the clock of a receiver without any time starts: the week of its firmware."""

MODE_2D_ONLY = 1
MODE_3D_ONLY = 2


class Engine:
    """Turns the world's epochs into what the receiver knows of them."""

    def __init__(self, default_leap_seconds: int) -> None:
        self.default_leap_seconds = default_leap_seconds
        self.systems: frozenset[str] = frozenset()
        self.fix_mode = 3
        self.running = False
        self.latest: Solution | None = None
        self._started_ns = 0
        self._state: StartState = "cold"
        self._times = START_TIMES["cold"]
        self._leap_known = False
        self._first_fix_ns: int | None = None
        self._course_deg = 0.0
        self._seen: tuple[Satellite, ...] = ()
        self._seen_by: frozenset[str] = frozenset()
        self._used = 0
        self._selected: tuple[Satellite, ...] = ()
        """What `_select` made of the satellites `_seen` for the systems `_seen_by`."""

    def start(self, now_ns: int, state: StartState) -> None:
        """Begin a search for satellites with what `state` says is still known."""
        self._started_ns = now_ns
        self._state = state
        self._times = START_TIMES[state]
        self._leap_known = self._times.leap_known
        self._first_fix_ns = None
        if state == "cold":
            self.latest = None
            self._course_deg = 0.0
        self.running = True

    def stop(self) -> None:
        """Stop the search and the navigation (CFG-RST mode 8); the clock goes on."""
        self.running = False

    def restart_state(self, off_ns: int) -> StartState:
        """The start that follows an interruption of `off_ns` with the backup supply kept."""
        latest = self.latest
        if latest is None or not latest.time_known:
            return self._state
        if latest.position_known and off_ns < EPHEMERIS_AGE_NS:
            return "hot"
        return "warm"

    def solve(self, epoch: GnssEpoch, now_ns: int) -> Solution:
        """The solution valid now."""
        elapsed = now_ns - self._started_ns
        used, satellites = self._select(epoch)
        time_known = epoch.time_known and elapsed >= self._times.time_ns
        fix = self._fix_type(epoch, used) if self.running and elapsed >= self._times.fix_ns else NO_FIX
        if fix and not self._leap_known:
            self._learn_leap_seconds(satellites, now_ns)
        leap = epoch.leap_seconds if self._leap_known else self.default_leap_seconds
        gps_time_ns = epoch.gps_time_ns if time_known else UNSET_CLOCK_NS + elapsed
        solution = Solution(epoch, gps_time_ns, utc_from_gps(gps_time_ns, leap), *gps_week(gps_time_ns))
        solution.time_known = time_known
        solution.leap_known = self._leap_known
        solution.leap_seconds = leap
        solution.running_ms = elapsed // 1_000_000
        if fix:
            if self._first_fix_ns is None:
                self._first_fix_ns = now_ns
            solution.fix = fix
            solution.used = used
            solution.satellites = satellites
            self._place(solution, epoch)
        else:
            self._remain(solution, satellites)
        if self._first_fix_ns is not None:
            solution.time_to_first_fix_ms = (self._first_fix_ns - self._started_ns) // 1_000_000
        return solution

    def _select(self, epoch: GnssEpoch) -> tuple[int, tuple[Satellite, ...]]:
        """Number used and list of the satellites of the enabled systems, the same ones while they last."""
        systems = self.systems
        if epoch.satellites is not self._seen or systems is not self._seen_by:
            self._seen, self._seen_by = epoch.satellites, systems
            self._selected = tuple([sat for sat in epoch.satellites if sat.system in systems])
            self._used = sum(sat.used for sat in self._selected)
        return self._used, self._selected

    def _fix_type(self, epoch: GnssEpoch, used: int) -> int:
        """The fix that the world grants, if the enabled systems carry it."""
        if not epoch.fix:
            return NO_FIX
        systems = self.systems
        if used < 3 and any(sat.used for sat in epoch.satellites if sat.system not in systems):
            return NO_FIX
        if used == 3 or self.fix_mode == MODE_2D_ONLY:
            return NO_FIX if self.fix_mode == MODE_3D_ONLY else FIX_2D
        return FIX_3D

    def _learn_leap_seconds(self, satellites: Sequence[Satellite], now_ns: int) -> None:
        """Leap seconds come with GLONASS at once, from the GPS almanac after a while."""
        glonass = any(satellite.used and satellite.system == "GLONASS" for satellite in satellites)
        since = 0 if self._first_fix_ns is None else now_ns - self._first_fix_ns
        self._leap_known = glonass or since >= LEAP_SECONDS_FROM_GPS_NS

    def _place(self, solution: Solution, epoch: GnssEpoch) -> None:
        """Position, speed and course of a fix."""
        solution.position_known = True
        solution.latitude_deg = degrees(epoch.latitude)
        solution.longitude_deg = longitude_degrees(epoch.longitude)
        solution.height = epoch.height
        solution.separation = epoch.geoid_separation
        north, east, _ = epoch.velocity_ned
        speed = math.hypot(north, east)
        solution.speed = speed
        if speed >= LOWEST_COURSE_SPEED and speed >= epoch.s_acc:
            course = degrees(math.atan2(east, north))
            self._course_deg = course if course >= 0.0 else course + 360.0
            solution.course_valid = True
        solution.course_deg = self._course_deg

    def _remain(self, solution: Solution, satellites: tuple[Satellite, ...]) -> None:
        """What is left without a fix: the last position, and the satellites once the time is known."""
        solution.course_deg = self._course_deg
        solution.sky_known = self._times.sky_known or self._first_fix_ns is not None
        if self.running and solution.time_known:
            solution.satellites = (
                satellites
                if solution.sky_known
                else tuple([satellite for satellite in satellites if satellite.cn0_dbhz > 0.0])
            )
        last = self.latest
        if last is not None and last.position_known:
            solution.position_known = True
            solution.latitude_deg = last.latitude_deg
            solution.longitude_deg = last.longitude_deg
            solution.height = last.height
            solution.separation = last.separation
