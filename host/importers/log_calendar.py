"""Dates for sentences that tell the time of day only: each is put on the day nearest to what came before.

Sentences before the first one with a date wait for it. `--date` states the day of the first time in the log;
dates in the log are then shifted by as many days (a receiver with a rolled-over week number tells dates 1024
weeks ago).
"""

from __future__ import annotations

from collections.abc import Callable

from host.importers.time_base import DAY_NS, GPS_EPOCH_UNIX_S, NS, leap_seconds_at
from host.record.errors import UserError

MOST_WAITING = 200_000
Placed = Callable[[int], None]
"""Told its GPS time in ns."""


class Calendar:
    """The clock of one log."""

    def __init__(self, first_day: int | None, leap_seconds: int | None) -> None:
        """`first_day`: days since 1970 of the first time in the log, when it was stated."""
        self._first_day = first_day
        self._leap_seconds = leap_seconds
        self._shift_days: int | None = None if first_day is not None else 0
        self._last_ns: int | None = None
        self._waiting: list[tuple[int, Placed]] = []

    @property
    def waits(self) -> bool:
        """Whether something waits for a date."""
        return bool(self._waiting)

    def date(self, day: int, time_of_day_ns: int) -> None:
        """A sentence tells day (since 1970) and time."""
        if self._shift_days is None:
            assert self._first_day is not None
            self._shift_days = self._day_now(time_of_day_ns) - day
        self._last_ns = (day + self._shift_days) * DAY_NS + time_of_day_ns
        self._settle(self._last_ns)

    def place(self, time_of_day_ns: int, placed: Placed) -> None:
        """Something of this time of day: told its time now, or when it is known."""
        if self._last_ns is None and self._first_day is not None:
            self._last_ns = self._first_day * DAY_NS + time_of_day_ns
        if self._last_ns is None:
            self._waiting.append((time_of_day_ns, placed))
            if len(self._waiting) > MOST_WAITING:
                raise UserError(NO_DATE)
            return
        self._last_ns = _nearest(time_of_day_ns, self._last_ns)
        placed(self.gps_ns(self._last_ns))

    def gps_ns(self, unix_ns: int) -> int:
        """GPS time of a Unix time."""
        leaps = leap_seconds_at(unix_ns) if self._leap_seconds is None else self._leap_seconds
        return unix_ns + (leaps - GPS_EPOCH_UNIX_S) * NS

    def _day_now(self, time_of_day_ns: int) -> int:
        if self._last_ns is None:
            assert self._first_day is not None
            return self._first_day
        return _nearest(time_of_day_ns, self._last_ns) // DAY_NS

    def _settle(self, now_ns: int) -> None:
        waiting, self._waiting = self._waiting, []
        times: list[int] = []
        for time_of_day_ns, _ in reversed(waiting):
            now_ns = _nearest(time_of_day_ns, now_ns)
            times.append(now_ns)
        for unix_ns, (_, placed) in zip(reversed(times), waiting, strict=True):
            placed(self.gps_ns(unix_ns))


NO_DATE = (
    "no sentence tells the date (RMC, ZDA or UBX do); state that of the first one, for example"
    " --date 2018-09-07"
)


def _nearest(time_of_day_ns: int, near_ns: int) -> int:
    """The instant with this time of day that lies nearest to another one."""
    same_day = near_ns // DAY_NS * DAY_NS + time_of_day_ns
    return min((same_day - DAY_NS, same_day, same_day + DAY_NS), key=lambda t: abs(t - near_ns))
