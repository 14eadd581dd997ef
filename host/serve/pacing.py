"""Lets a session's virtual time pass at a pace: real time, a multiple of it, or as fast as it goes (0).

One thread. Virtual time passes in slices: `SLICE_S` of wall-clock time each, at the end of which the slice is
worked off in one go (a board second takes some 2 ms) and handed out. Bytes therefore reach clients up to a
slice late, and never early. Every fifth slice ends at a *deadline*, 10 ms of wall-clock time apart; how late
it was worked off and handed out is what `lateness` tells.

The wall clock decides when a slice is worked off, never what is in it: two runs with the same input at the
same virtual times are equal byte for byte, whatever the pace.

Falling behind. A slice that comes late is not dropped: the run works off slice after slice without waiting
until it is in time again, so virtual time keeps step with the wall clock. Only when it is more than `SLIP_S`
behind (the machine was suspended, or is too slow for the pace asked for) the clock is moved: the wall-clock
time lost is counted in `slipped_s` and told.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Protocol

from hal.emulated.virtual_time import SECOND
from host.run.session import RunSession
from host.serve.lateness import Lateness

SLICE_S = 0.002
SLICES_A_DEADLINE = 5
SLIP_S = 1.0
FAST_SLICE_NS = 200_000_000
"""Virtual time of a slice when nothing is paced."""
LOOK_EVERY_S = 1.0
"""Wall-clock time between two looks at what the board sent (decoding, scoring)."""
IDLE_S = 0.05
SLOWEST, FASTEST = 0.001, 10_000.0

Clock = Callable[[], int]


class Outside(Protocol):
    """Whoever stands around the board while time passes."""

    def bring_in(self) -> None:
        """Right before a slice: put on the board's wires what has come for it."""
        ...

    def hand_out(self) -> None:
        """Right after a slice: give away what the board has sent."""
        ...

    def wait(self, seconds: float) -> None:
        """Wait for something to happen outside, at most so long."""
        ...

    def holds_up(self) -> bool:
        """Whether the run, when it is not paced, must wait for somebody who reads."""
        ...

    def look_around(self) -> None:
        """Now and then, right after a deadline: what may take some milliseconds."""
        ...


class PacedRun:
    """A session that runs at `pace`; `pause`, `resume`, `set_pace` and `stop` may be called by `outside`."""

    def __init__(
        self, session: RunSession, outside: Outside, pace: float, clock_ns: Clock = time.monotonic_ns
    ) -> None:
        self.session = session
        self.pace = pace
        self.paused = False
        self.lateness = Lateness()
        self.slips = 0
        self.slipped_s = 0.0
        self._ran_s = 0.0
        self._outside = outside
        self._clock_ns = clock_ns
        self._stopped = False
        self._runs = False
        self._since_ns = 0
        """Wall-clock time of the last beginning or resuming."""
        self._from_wall_ns = clock_ns()
        self._from_virtual_ns = session.now_ns
        self._slices = 0
        self._looked_wall_ns = self._from_wall_ns

    # -- what may be asked for ---------------------------------------------------------------------

    def pause(self) -> None:
        """Let no time pass until `resume`."""
        self._ran_s = self.running_s
        self.paused = True

    def resume(self) -> None:
        """Go on from here."""
        if self.paused:
            self.paused = False
            self._since_ns = self._clock_ns()
            self._anew()

    def set_pace(self, pace: float) -> None:
        """Another pace from here on."""
        self.pace = pace
        self._anew()

    def stop(self) -> None:
        """Let no more time pass; `run` returns."""
        self._stopped = True

    @property
    def running_s(self) -> float:
        """Wall-clock time in which virtual time was to pass: all but the pauses."""
        under_way = 0.0 if self.paused or not self._runs else (self._clock_ns() - self._since_ns) / SECOND
        return self._ran_s + under_way

    @property
    def stopped(self) -> bool:
        """Whether it was asked to stop."""
        return self._stopped

    @property
    def behind_s(self) -> float:
        """How far virtual time is behind its pace now, s of wall-clock time; 0 while unpaced or paused."""
        if not self.pace or self.paused:
            return 0.0
        return max(0.0, (self._clock_ns() - self._due_ns(self._slices)) / SECOND)

    def virtual_at(self, wall_ns: int) -> int:
        """The virtual time that an instant of the wall clock belongs to; at pace 0 the present one."""
        if not self.pace:
            return self.session.now_ns
        return self._from_virtual_ns + round((wall_ns - self._from_wall_ns) * self.pace)

    # -- the loop ----------------------------------------------------------------------------------

    def run(self, end_ns: int) -> None:
        """Let virtual time pass to `end_ns`, or until `stop`."""
        self._runs = True
        self._since_ns = self._clock_ns()
        self._anew()
        while self.session.now_ns < end_ns and not self._stopped:
            if self.paused:
                self._outside.wait(IDLE_S)
                self._look_if_due()
            elif self.pace:
                self._paced_slice(end_ns)
            else:
                self._free_slice(end_ns)
        self._ran_s = self.running_s
        self._runs = False

    def _free_slice(self, end_ns: int) -> None:
        if self._outside.holds_up():
            self._outside.wait(IDLE_S)
        else:
            self._work_off(min(self.session.now_ns + FAST_SLICE_NS, end_ns))
            self._outside.wait(0.0)
        self._look_if_due()

    def _paced_slice(self, end_ns: int) -> None:
        """Wait for the end of the next slice, or work it off when that has come."""
        number = self._slices + 1
        due_ns = self._due_ns(number)
        self._outside.wait(max(0, due_ns - self._clock_ns()) / SECOND)
        if self.paused or self._stopped or due_ns != self._due_ns(self._slices + 1):
            return
        if self._clock_ns() < due_ns:
            return
        self._slices = number
        self._work_off(min(max(self._virtual_ns(number), self.session.now_ns), end_ns))
        late_ns = self._clock_ns() - due_ns
        if number % SLICES_A_DEADLINE == 0:
            self.lateness.add(late_ns)
            self._look_if_due()
        if late_ns > SLIP_S * SECOND:
            self.slips += 1
            self.slipped_s += late_ns / SECOND
            self._anew()

    def _work_off(self, end_ns: int) -> None:
        self._outside.bring_in()
        self.session.run_until(end_ns)
        self._outside.hand_out()

    def _look_if_due(self) -> None:
        now_ns = self._clock_ns()
        if now_ns - self._looked_wall_ns >= LOOK_EVERY_S * SECOND:
            self._looked_wall_ns = now_ns
            self.session.look()
            self._outside.look_around()

    # -- the pace ----------------------------------------------------------------------------------

    def _due_ns(self, number: int) -> int:
        """Wall-clock time at which the slice `number` since the last start is to end."""
        return self._from_wall_ns + round(number * SLICE_S * SECOND)

    def _virtual_ns(self, number: int) -> int:
        return self._from_virtual_ns + round(number * SLICE_S * SECOND * self.pace)

    def _anew(self) -> None:
        """Count slices from this instant."""
        self._from_wall_ns = self._clock_ns()
        self._from_virtual_ns = self.session.now_ns
        self._slices = 0
        self.lateness.break_off()
