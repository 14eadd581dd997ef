"""What the DSP makes of collected positions, procedure by procedure, with the kernels of least squares.

Each takes the whole numbers of `collecting` position by position and gives a result as `calibration` stores
it, or says why there is none.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final, Protocol

import numpy as np
from numpy.typing import NDArray

from firmware.apps.gfsins import positions
from firmware.apps.gfsins.collecting import AXES, FRACTION
from firmware.apps.gfsins.settings_packet import Result
from firmware.drivers.adxl345_sample import LSB_PER_G, STANDARD_GRAVITY
from firmware.nav.gyro_free import alignment as rest
from firmware.nav.gyro_free import compass_calibration as compass
from firmware.nav.gyro_free import layout as gl
from firmware.nav.gyro_free import least_squares as ls
from firmware.nav.gyro_free import table_calibration as table
from firmware.nav.gyro_free.config import GyroFreeConfig, new_sensor
from firmware.numerics.dialect import entry_point

COUNT: Final = STANDARD_GRAVITY / LSB_PER_G / (1 << FRACTION)
"""m/s² of a count as it is sent."""
TENTH: Final = math.pi / 1800.0 / (1 << FRACTION)
FIELD: Final = 1.0 / 4096.0 / (1 << FRACTION)
"""Fields near 1: 4096 counts are 0.41 gauss."""
MICRO: Final = 1e-6
WORST_RESPONSE, WORST_CROSS, WORST_OFFSET = 0.15, 0.1, 0.4 * STANDARD_GRAVITY
WORST_DEVIATION: Final = 1.0
WORST_REST: Final = 0.3 * STANDARD_GRAVITY
SIZES: Final = {
    "accelerometers": 63,
    "rates": 24,
    "earth-rate": 24,
    "compass": 10,
    "ellipse": 15,
    "alignment": 9,
}
"""Numbers of each result."""
Floats = NDArray[Any]
Outcome = tuple[Result, tuple[float, ...]]
NOT_TOLD: Final[Outcome] = (Result.NOT_TOLD, ())
IMPLAUSIBLE: Final[Outcome] = (Result.IMPLAUSIBLE, ())


class Place:
    """Where the table stands."""

    def __init__(self, values: Sequence[int]) -> None:
        known = len(values) == 3 and bool(values[2])
        self.latitude = math.radians(values[0] * 1e-7) if known else 0.0
        """rad; 0 when it is not known."""
        height = values[1] * 1e-3 if known else 0.0
        self.gravity = positions.gravity_at(self.latitude, height) if known else STANDARD_GRAVITY


class Solution(Protocol):
    """One procedure."""

    def take(self, index: int, values: Sequence[int]) -> None:
        """What was collected in a position; they come in order."""
        ...

    def solve(self) -> Outcome:
        """The result."""
        ...


def _equations(count: int) -> list[Floats]:
    return [np.zeros(ls.SIZE, np.float32) for _ in range(count)]


def _solved(axes: Sequence[Floats]) -> list[float] | None:
    result = np.zeros(table.RESULT_SIZE, np.float32)
    solve = entry_point(table.solve_positions)
    return (
        result.tolist() if solve(axes[0], axes[1], axes[2], result) and np.all(np.isfinite(result)) else None
    )


class Accelerometers:
    """Nine of them: response, offset, and the matrix of those at the origin."""

    def __init__(self, place: Place) -> None:
        self._place = place
        self._axes = _equations(AXES)
        self._take = entry_point(table.take_position)

    def take(self, index: int, values: Sequence[int]) -> None:
        """Mean counts of nine, uncorrected."""
        felt = positions.true_force_and_rate(index, self._place.latitude, self._place.gravity)[:3].tolist()
        for q, value in zip(self._axes, values[:AXES], strict=True):
            self._take(q, felt[0], felt[1], felt[2], value * COUNT)

    def solve(self) -> Outcome:
        """See `Solution`."""
        triads = [_solved(self._axes[k : k + 3]) for k in range(0, AXES, 3)]
        told: list[float] = []
        for triad in triads:
            if triad is None:
                return NOT_TOLD
            for axis in range(3):
                told += _axis(triad, axis)
        if not all(_is_plausible(told[k : k + 6]) for k in range(0, len(told), 6)):
            return IMPLAUSIBLE
        origin = triads[2]
        assert origin is not None
        own = [origin[table.RESPONSE + 4 * axis] for axis in range(3)]
        told += [origin[table.MATRIX + k] * own[k % 3] for k in range(9)]
        return Result.DONE, tuple(told)


def _axis(triad: Sequence[float], axis: int) -> list[float]:
    """Response along its axis, along the next two, offset, σ of the first and of the offset."""
    row = triad[table.RESPONSE + 3 * axis : table.RESPONSE + 3 * axis + 3]
    sigma = triad[table.SIGMA_RESPONSE + 4 * axis]
    return [
        row[axis],
        row[(axis + 1) % 3],
        row[(axis + 2) % 3],
        triad[table.OFFSET + axis],
        sigma,
        triad[table.SIGMA_OFFSET + axis],
    ]


def _is_plausible(axis: Sequence[float]) -> bool:
    own, second, third, offset = axis[:4]
    return (
        abs(own - 1.0) < WORST_RESPONSE
        and abs(second) < WORST_CROSS
        and abs(third) < WORST_CROSS
        and abs(offset) < WORST_OFFSET
    )


class Rates:
    """Three rates, from what nine accelerometers gained in turning."""

    def __init__(self, place: Place, per_two_arms: float, earth: bool) -> None:
        self._place = place
        self._per_two_arms = per_two_arms
        self._earth = earth
        self._axes = _equations(3)
        self._take = entry_point(table.take_position)

    def take(self, index: int, values: Sequence[int]) -> None:
        """∫ of nine counts, corrected."""
        a1, a2, a3, a4, a5, a6, a7, a8, a9 = (value * COUNT * self._per_two_arms for value in values[:AXES])
        read = a8 + a9 - a2 - a6, a7 + a9 - a3 - a4, a7 + a8 - a1 - a5
        true = self._true(index)
        for q, value in zip(self._axes, read, strict=True):
            self._take(q, true[0], true[1], true[2], value)

    def _true(self, index: int) -> Sequence[float]:
        if not self._earth:
            return positions.true_rate(index)
        place = self._place
        felt: list[float] = positions.true_force_and_rate(index, place.latitude, place.gravity).tolist()
        return felt[3:]

    def solve(self) -> Outcome:
        """Matrix, bias, σ of response and offset; of the Earth's rate the response instead of the matrix."""
        result = _solved(self._axes)
        if result is None:
            return NOT_TOLD
        sigmas = result[table.SIGMA_RESPONSE :]
        if self._earth:
            return Result.DONE, (*result[table.RESPONSE : table.SIGMA_RESPONSE], *sigmas)
        own = [abs(result[table.MATRIX + 4 * axis] - 1.0) for axis in range(3)]
        if max(own) > WORST_RESPONSE:
            return IMPLAUSIBLE
        return Result.DONE, (*result[table.MATRIX : table.RESPONSE], *sigmas)


class Headings:
    """The deviation, from headings that a table tells."""

    def __init__(self) -> None:
        self._q = np.zeros(ls.SIZE, np.float32)
        self._take = entry_point(compass.take_heading)

    def take(self, index: int, values: Sequence[int]) -> None:
        """Mean heading shown, in tenths of a degree."""
        shown = values[0] * TENTH % (2.0 * math.pi)
        self._take(self._q, shown, positions.true_heading(index))

    def solve(self) -> Outcome:
        """A … E and their σ."""
        if not entry_point(compass.solve_deviation)(self._q):
            return NOT_TOLD
        found = (*self._q[ls.X : ls.X + 5].tolist(), *self._q[ls.SIGMA : ls.SIGMA + 5].tolist())
        if not all(abs(x) < WORST_DEVIATION for x in found):
            return IMPLAUSIBLE
        return Result.DONE, found


class Ellipse:
    """The deviation from fields alone: the table's headings need not be true ones."""

    def __init__(self) -> None:
        self._q = np.zeros(ls.SIZE, np.float32)
        self._fields: list[tuple[float, float]] = []
        self._take = entry_point(compass.take_field)

    def take(self, index: int, values: Sequence[int]) -> None:
        """Mean field along the chip's x and y on the level, counts."""
        field = values[3] * FIELD, values[4] * FIELD
        self._fields.append(field)
        self._take(self._q, *field)

    def solve(self) -> Outcome:
        """A … E with their σ, then soft iron and hard iron (counts)."""
        iron = np.zeros(compass.ELLIPSE_SIZE, np.float32)
        if not entry_point(compass.solve_ellipse)(self._q, iron):
            return NOT_TOLD
        xx, xy, yy, hard_x, hard_y = iron.tolist()
        q = np.zeros(ls.SIZE, np.float32)
        take = entry_point(compass.take_heading)
        for x, y in self._fields:
            u, v = x - hard_x, y - hard_y
            take(q, _heading(x, y), _heading(xx * u + xy * v, xy * u + yy * v))
        if not entry_point(compass.solve_deviation)(q):
            return NOT_TOLD
        found = (*q[ls.X : ls.X + 5].tolist(), *q[ls.SIGMA : ls.SIGMA + 5].tolist())
        if not all(abs(x) < WORST_DEVIATION for x in found):
            return IMPLAUSIBLE
        return Result.DONE, (*found, xx, xy, yy, hard_x * 4096.0, hard_y * 4096.0)


def _heading(x: float, y: float) -> float:
    """Of a level field, x forward and y left."""
    return math.atan2(y, x) % (2.0 * math.pi)


class AtRest:
    """Attitude, and the arms' accelerometers made equal to those at the origin."""

    def __init__(self, config: GyroFreeConfig) -> None:
        self._g, self._n = new_sensor(config)
        self._sums = np.zeros(rest.SIZE, np.float32)
        self._true_heading = 0.0
        self._has_taken = False

    def take(self, index: int, values: Sequence[int]) -> None:
        """Mean counts of nine, corrected, the heading shown, and A … E in µrad."""
        sums = self._sums
        sums[rest.MEANS : rest.MEANS + AXES] = [value * COUNT for value in values[:AXES]]
        a, b, c, d, e = (value * MICRO for value in values[AXES + 1 : AXES + 6])
        shown = values[AXES] * TENTH
        s, k = math.sin(shown), math.cos(shown)
        deviation = a + b * s + c * k + d * 2.0 * s * k + e * (k * k - s * s)
        heading = shown - deviation + float(self._g[gl.DECLINATION])
        sums[rest.SINE], sums[rest.COSINE] = math.sin(heading), math.cos(heading)
        sums[rest.SAMPLES] = sums[rest.READINGS] = 1.0

    def solve(self) -> Outcome:
        """Yaw, pitch, roll, then six offsets."""
        angles = np.zeros(3, np.float32)
        if not entry_point(rest.finish_alignment)(self._g, self._n, self._sums, angles):
            return NOT_TOLD
        offsets = self._g[gl.OFFSET : gl.OFFSET + 6].tolist()
        if max(map(abs, offsets)) > WORST_REST:
            return IMPLAUSIBLE
        return Result.DONE, (*angles.tolist(), *offsets)


def solution_of(name: str, place: Place, config: GyroFreeConfig) -> Solution:
    """A new one of a procedure."""
    if name == "accelerometers":
        return Accelerometers(place)
    if name in positions.TURNED:
        return Rates(place, 0.5 / config.arm_length, name == "earth-rate")
    if name == "compass":
        return Headings()
    return Ellipse() if name == "ellipse" else AtRest(config)
