"""The Earth's magnetic field by the World Magnetic Model, through pygeomag.

The model is evaluated in the middle of cells of 0.05° and 1 km, with its gradient, at the drive's start: away
from the poles that is the model itself within 0.1 nT, and a function of the place alone.
"""

from __future__ import annotations

import functools
import math
from datetime import UTC, datetime

import numpy as np
from numpy.typing import NDArray

from host.record.errors import UserError
from host.sim.compiled import entry

Floats = NDArray[np.float64]

CELL_DEG, CELL_KM = 0.05, 1.0
MODELS = {2010: "WMM_2010", 2015: "WMM_2015v2", 2020: "WMM_2020", 2025: "WMM_2025"}
"""By first year; each holds for five."""
LAST_YEAR = 2030
NANO = 1e-9
CELLS_KEPT = 64
SIDES = (math.degrees(1.0) / CELL_DEG, math.degrees(1.0) / CELL_DEG, 1.0 / (1000.0 * CELL_KM))
"""Of a cell: cells in a rad of latitude, of longitude, in a m of height."""


class MagneticField:
    """The field in the course of a drive."""

    def __init__(self, start_utc: str) -> None:
        """`start_utc`: ISO 8601. Raises UserError when no model holds then."""
        from pygeomag import GeoMag

        self._year = decimal_year(datetime.fromisoformat(start_utc))
        first, end = min(MODELS), LAST_YEAR
        if not first <= self._year < end:
            raise UserError(
                f"start.utc = {start_utc}: no World Magnetic Model of pygeomag holds then, they do"
                f' from {first} to the end of {end - 1}; for example start.utc = "2024-05-14T08:00:00Z"'
            )
        epoch = max(year for year in MODELS if year <= self._year)
        self._model = GeoMag(coefficients_file=f"wmm/{MODELS[epoch]}.COF")
        self._cell = functools.lru_cache(CELLS_KEPT)(self._computed)

    def turned(self, place: tuple[Floats, Floats, Floats], c_nb: Floats) -> Floats:
        """(n, 3) in T at latitudes, longitudes (rad), heights (m above the ellipsoid), in the axes of
        attitudes C_n_b (n, 3, 3)."""
        out = np.empty((len(c_nb), 3))
        done = 0
        while done < len(out):
            i, j, k = (round(float(along[done]) * side) for along, side in zip(place, SIDES, strict=True))
            done = turn_in_cell(*place, c_nb, done, i, j, k, *self._cell(i, j, k), out)
        return out

    def _computed(self, i: int, j: int, k: int) -> tuple[Floats, Floats]:
        """The field in the middle of a cell (3,), and how it grows along its three sides (3, 3)."""
        sides = np.eye(3)
        middle = np.array([i, j, k], dtype=np.float64)
        ahead = np.array([self._model_at(middle + 0.5 * side) for side in sides])
        behind = np.array([self._model_at(middle - 0.5 * side) for side in sides])
        return self._model_at(middle), ahead - behind

    def _model_at(self, place: Floats) -> Floats:
        lat, lon, height_km = (place * (CELL_DEG, CELL_DEG, CELL_KM)).tolist()
        lon = (lon + 180.0) % 360.0 - 180.0
        found = self._model.calculate(glat=lat, glon=lon, alt=height_km, time=self._year)
        return np.array([found.x, found.y, found.z]) * NANO


@entry
def turn_in_cell(
    latitude: Floats,
    longitude: Floats,
    height: Floats,
    c_nb: Floats,
    first: int,
    i: int,
    j: int,
    k: int,
    middle: Floats,
    gradient: Floats,
    out: Floats,
) -> int:
    """Fill rows of `out` with C_b_n m_n from `first` on, which lies in the cell (i, j, k); returns the first
    row of another cell, or their number."""
    for row in range(first, out.shape[0]):
        x, y, z = latitude[row] * SIDES[0], longitude[row] * SIDES[1], height[row] * SIDES[2]
        outside = np.rint(x) != i or np.rint(y) != j or np.rint(z) != k
        if outside and row > first:
            return row
        x, y, z = x - i, y - j, z - k
        north = middle[0] + (x * gradient[0, 0] + y * gradient[1, 0] + z * gradient[2, 0])
        east = middle[1] + (x * gradient[0, 1] + y * gradient[1, 1] + z * gradient[2, 1])
        down = middle[2] + (x * gradient[0, 2] + y * gradient[1, 2] + z * gradient[2, 2])
        for axis in range(3):
            out[row, axis] = (
                c_nb[row, 0, axis] * north + c_nb[row, 1, axis] * east + c_nb[row, 2, axis] * down
            )
    return out.shape[0]


def decimal_year(moment: datetime) -> float:
    """2024.5 for the middle of 2024."""
    year = moment.year
    begin, end = datetime(year, 1, 1, tzinfo=UTC), datetime(year + 1, 1, 1, tzinfo=UTC)
    value = year + (moment - begin) / (end - begin)
    assert math.isfinite(value)
    return value
