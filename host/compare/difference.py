"""How far one arithmetic is from another: first seen, largest, and growing over time.

Quantities of a difference, from the integer records of both:

    attitude    total rotation between the two q_nb, °
    yaw, pitch, roll    wrapped, °;    rate    |Δω|, °/s
    velocity    |Δv|, m/s;    position    horizontal, m;    height    m
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from firmware.nav.attitude import layout as at
from host.record.series import DecimatedSeries
from host.sim.earth import radians_per_metre
from host.tables.angle_errors import rotation_between_quaternions, wrapped

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

UNITS = {
    "attitude": "°",
    "yaw": "°",
    "pitch": "°",
    "roll": "°",
    "rate": "°/s",
    "velocity": "m/s",
    "position": "m",
    "height": "m",
}
QUANTITIES = tuple(UNITS)
HALF_TURN = 180 * 10**9
"""1e-9 degree."""
NANO_DEG = np.degrees(1e-9)
STEPS_S = (1, 3, 10, 30, 60, 120, 300, 600, 1_200, 3_600, 7_200, 18_000, 36_000, 86_400)
"""Times since the first iteration at which the growth is told."""


@dataclass(frozen=True, slots=True)
class First:
    """When a difference was first seen, s of virtual time, and how large it was."""

    t_s: float
    amount: float


@dataclass(slots=True)
class Growth:
    """Largest and RMS of each quantity from the first iteration up to a time."""

    since_s: float
    now: Floats
    rms: Floats
    largest: Floats


@dataclass
class Difference:
    """Of one arithmetic against the reference, summed up as the stream goes by."""

    arithmetic: str
    reference: str
    count: int = 0
    only_one: int = 0
    """Iterations that but one of the two made: they did not begin or end together."""
    first: dict[str, First] = field(default_factory=dict)
    growth: list[Growth] = field(default_factory=list)
    series: DecimatedSeries = field(default_factory=lambda: DecimatedSeries(("t_s", *QUANTITIES), 2048))
    largest: Floats = field(default_factory=lambda: np.zeros(len(QUANTITIES)))
    largest_at_s: Floats = field(default_factory=lambda: np.zeros(len(QUANTITIES)))
    _squares: Floats = field(default_factory=lambda: np.zeros(len(QUANTITIES)))
    _began_s: float | None = None
    _last: Floats = field(default_factory=lambda: np.zeros(len(QUANTITIES)))
    _last_s: float = 0.0

    @property
    def rms(self) -> dict[str, float]:
        """Of everything so far."""
        return dict(zip(QUANTITIES, self._rms().tolist(), strict=True))

    @property
    def at_end(self) -> dict[str, float]:
        """The last one."""
        return dict(zip(QUANTITIES, self._last.tolist(), strict=True))

    def add(self, times_s: Floats, one: Integers, other: Integers) -> None:
        """Records (n, OUT_SIZE) of both at the same times."""
        if not len(times_s):
            return
        off = differences(one, other)
        if self._began_s is None:
            self._began_s = float(times_s[0])
        self._note_first(times_s, off)
        done = 0
        for step in STEPS_S:
            end = int(np.searchsorted(times_s, self._began_s + step))
            if self._last_s < self._began_s + step and end < len(times_s):
                self._sum_up(times_s[done:end], off[done:end])
                done = max(done, end)
                if self.count:
                    self.growth.append(self._state(float(step)))
        self._sum_up(times_s[done:], off[done:])
        self.series.add(np.column_stack((times_s, off)))

    def finish(self) -> None:
        """The stream has ended: its end counts as the last step of the growth."""
        if self.count and self._began_s is not None:
            self.growth.append(self._state(self._last_s - self._began_s))

    def _state(self, since_s: float) -> Growth:
        return Growth(since_s, self._last.copy(), self._rms(), self.largest.copy())

    def _rms(self) -> Floats:
        return np.sqrt(self._squares / max(1, self.count))

    def _note_first(self, times_s: Floats, off: Floats) -> None:
        for column, name in enumerate(QUANTITIES):
            if name not in self.first and (seen := np.flatnonzero(off[:, column])).size:
                place = int(seen[0])
                self.first[name] = First(float(times_s[place]), float(off[place, column]))

    def _sum_up(self, times_s: Floats, off: Floats) -> None:
        if not len(times_s):
            return
        self.count += len(times_s)
        self._squares += np.sum(off * off, axis=0)
        places = np.argmax(off, axis=0)
        peaks = off[places, np.arange(off.shape[1])]
        higher = peaks > self.largest
        self.largest = np.where(higher, peaks, self.largest)
        self.largest_at_s = np.where(higher, times_s[places], self.largest_at_s)
        self._last, self._last_s = off[-1].copy(), float(times_s[-1])


def differences(one: Integers, other: Integers) -> Floats:
    """(n, QUANTITIES) of records (n, OUT_SIZE), none of them negative."""
    change = (one - other).astype(np.float64)
    angles = np.degrees(np.abs(wrapped(change[:, [at.OUT_YAW, at.OUT_PITCH, at.OUT_ROLL]] * 1e-9)))
    rate = np.linalg.norm(change[:, at.OUT_RATE : at.OUT_RATE + 3], axis=1) * NANO_DEG
    velocity = np.linalg.norm(change[:, at.OUT_VELOCITY : at.OUT_VELOCITY + 3], axis=1) * 1e-6
    return np.column_stack(
        (
            _rotation(one, other),
            angles,
            rate,
            velocity,
            _metres(one, other),
            np.abs(change[:, at.OUT_HEIGHT]) * 1e-6,
        )
    )


def _rotation(one: Integers, other: Integers) -> Floats:
    pair = []
    for records in (one, other):
        q = records[:, at.OUT_QUATERNION : at.OUT_QUATERNION + 4].astype(np.float64)
        pair.append(q / np.maximum(np.linalg.norm(q, axis=1), 1.0)[:, None])
    same = np.all(pair[0] == pair[1], axis=1)
    turned = np.degrees(rotation_between_quaternions(pair[0], pair[1]))
    return np.where(same, 0.0, turned)


def _metres(one: Integers, other: Integers) -> Floats:
    """Horizontal distance."""
    latitude = float(np.radians(other[0, at.OUT_LATITUDE] * 1e-9))
    per_north, per_east = radians_per_metre(latitude, float(other[0, at.OUT_HEIGHT] * 1e-6))
    north = np.radians((one[:, at.OUT_LATITUDE] - other[:, at.OUT_LATITUDE]) * 1e-9) / per_north
    apart = one[:, at.OUT_LONGITUDE] - other[:, at.OUT_LONGITUDE]
    east = np.radians(((apart + HALF_TURN) % (2 * HALF_TURN) - HALF_TURN) * 1e-9) / per_east
    return np.asarray(np.hypot(north, east), np.float64)
