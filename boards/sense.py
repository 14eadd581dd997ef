"""What a chip feels, with the defects of its sensor element: frozen, stuck, saturated, drifting, turned.

A defect changes what the world tells within its time, by the instants of the samples: chips ask for samples
ahead. The chip behind it quantises, filters, clips and sends as ever. `fired` counts samples (of a receiver:
epochs) that it changed.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from boards.chips.world import GnssEpoch

Floats = NDArray[np.float64]
Times = NDArray[np.int64]

COLUMNS: dict[int, dict[str, range]] = {
    7: {"accel": range(3), "gyro": range(3, 6), "mag": range(3, 6), "temperature": range(6, 7)},
    11: {
        "accel": range(3),
        "gyro": range(3, 6),
        "temperature": range(6, 7),
        "mag": range(7, 10),
        "pressure": range(10, 11),
    },
}
"""Where each quantity stands in the worlds of seven and of eleven columns (`boards.chips.world`)."""
AXES = {"x": 0, "y": 1, "z": 2}
BEYOND_ALL_RANGES = 1e4
"""In SI units: 1000 g, 1600 turns a second, 10⁸ gauss."""


class Defect:
    """A defect of some quantities of one sensor, from `start_ns` to `end_ns`.

    `quantities`: of "accel", "gyro", "mag", "pressure", "temperature". `axis`: "x", "y", "z" or "all".
    """

    def __init__(self, start_ns: int, end_ns: int, quantities: tuple[str, ...], axis: str = "all") -> None:
        if axis != "all" and axis not in AXES:
            raise ValueError(f"axis {axis!r}; it is 'x', 'y', 'z' or 'all'")
        self.start_ns = start_ns
        self.end_ns = end_ns
        self.fired = 0
        self._quantities = quantities
        self._axis = axis

    def apply(self, times_ns: Times, values: Floats) -> None:
        """Change the samples that lie in its time."""
        struck = np.flatnonzero((times_ns >= self.start_ns) & (times_ns < self.end_ns))
        if not len(struck):
            return
        self.fired += len(struck)
        for quantity in self._quantities:
            columns = COLUMNS[values.shape[1]][quantity]
            for column in (
                columns if self._axis == "all" or len(columns) == 1 else (columns[AXES[self._axis]],)
            ):
                values[struck, column] = self.spoil(column, times_ns[struck], values[struck, column])

    def spoil(self, column: int, times_ns: Times, good: Floats) -> Floats | float:
        """What a column shows instead."""
        raise NotImplementedError

    def epoch(self, time_ns: int, epoch: GnssEpoch) -> GnssEpoch:
        """The same for a receiver's epoch."""
        raise NotImplementedError


class Frozen(Defect):
    """The values stay as they are at its beginning. A receiver repeats its position and velocity while its
    clock goes on."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._held: dict[int, float] = {}
        self._epoch: GnssEpoch | None = None

    def spoil(self, column: int, times_ns: Times, good: Floats) -> Floats | float:
        """The first value in its time."""
        return self._held.setdefault(column, float(good[0]))

    def epoch(self, time_ns: int, epoch: GnssEpoch) -> GnssEpoch:
        """The first epoch in its time, with the time of this one."""
        if not self.start_ns <= time_ns < self.end_ns:
            return epoch
        if self._epoch is None:
            self._epoch = epoch
        self.fired += 1
        return replace(self._epoch, gps_time_ns=epoch.gps_time_ns, time_known=epoch.time_known)


class Stuck(Defect):
    """The values are `value`, in SI units."""

    def __init__(self, *args: Any, value: float = 0.0, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._value = value

    def spoil(self, column: int, times_ns: Times, good: Floats) -> Floats | float:
        """That value."""
        return self._value


class Saturated(Stuck):
    """The values lie beyond every range: the chip shows its largest, or smallest, number."""

    def __init__(self, *args: Any, negative: bool = False, **kwargs: Any) -> None:
        super().__init__(*args, value=-BEYOND_ALL_RANGES if negative else BEYOND_ALL_RANGES, **kwargs)


class Turned(Defect):
    """The sensor sits turned by 180° about `axis`, one of the three: the other two show the opposite."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        if self._axis == "all":
            raise ValueError("axis 'all'; a sensor is turned about 'x', 'y' or 'z'")

    def apply(self, times_ns: Times, values: Floats) -> None:
        """Change the signs in its time."""
        struck = np.flatnonzero((times_ns >= self.start_ns) & (times_ns < self.end_ns))
        self.fired += len(struck)
        for quantity in self._quantities:
            columns = COLUMNS[values.shape[1]][quantity]
            if len(columns) == len(AXES):
                for k, column in enumerate(columns):
                    if k != AXES[self._axis]:
                        values[struck, column] *= -1.0


class Drift(Defect):
    """The values run away by `rate`, in SI units a second."""

    def __init__(self, *args: Any, rate: float = 0.01, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._rate = rate

    def spoil(self, column: int, times_ns: Times, good: Floats) -> Floats | float:
        """A ramp on top."""
        return good + self._rate * 1e-9 * (times_ns - self.start_ns)


class Sense:
    """The world face of one chip with its `defects`; without any it only passes on."""

    def __init__(self, world: Any) -> None:
        self._world = world
        self.most_ahead_s: float = getattr(world, "most_ahead_s", math.inf)
        self.defects: list[Defect] = []

    def sample(self, times_ns: Times, *bandwidth_hz: float) -> Floats:
        """See the world protocols of `boards.chips.world`."""
        values: Floats = self._world.sample(times_ns, *bandwidth_hz)
        if self.defects:
            values = np.array(values, np.float64)
            for defect in self.defects:
                defect.apply(times_ns, values)
        return values

    def foresee(self, times_ns: Times) -> None:
        """See `boards.chips.world.CompassWorld`."""
        foresee = getattr(self._world, "foresee", None)
        if foresee is not None:
            foresee(times_ns)

    def epoch(self, time_ns: int) -> GnssEpoch:
        """See `boards.chips.world.GnssWorld`."""
        epoch: GnssEpoch = self._world.epoch(time_ns)
        for defect in self.defects:
            epoch = defect.epoch(time_ns, epoch)
        return epoch
