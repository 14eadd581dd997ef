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

Floats = NDArray[np.float64]

CELL_DEG, CELL_KM = 0.05, 1.0
MODELS = {2010: "WMM_2010", 2015: "WMM_2015v2", 2020: "WMM_2020", 2025: "WMM_2025"}
"""By first year; each holds for five."""
LAST_YEAR = 2030
NANO = 1e-9
CELLS_KEPT = 64


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

    def at(self, latitude: Floats, longitude: Floats, height: Floats) -> Floats:
        """(n, 3) north, east, down in T at places (rad, m above the ellipsoid)."""
        places = np.empty((len(latitude), 3))
        np.multiply(latitude, math.degrees(1.0) / CELL_DEG, out=places[:, 0])
        np.multiply(longitude, math.degrees(1.0) / CELL_DEG, out=places[:, 1])
        np.multiply(height, 1.0 / (1000.0 * CELL_KM), out=places[:, 2])
        cells = np.rint(places)
        out = np.empty((len(places), 3))
        begin = 0
        for end in [*(np.flatnonzero((cells[1:] != cells[:-1]).any(axis=1)) + 1).tolist(), len(places)]:
            if end > begin:
                middle, gradient = self._cell(*cells[begin].astype(np.int64).tolist())
                out[begin:end] = middle + (places[begin:end] - cells[begin]) @ gradient
            begin = end
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


def decimal_year(moment: datetime) -> float:
    """2024.5 for the middle of 2024."""
    year = moment.year
    begin, end = datetime(year, 1, 1, tzinfo=UTC), datetime(year + 1, 1, 1, tzinfo=UTC)
    value = year + (moment - begin) / (end - begin)
    assert math.isfinite(value)
    return value
