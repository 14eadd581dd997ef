"""The ISO 2533 (US 1976) standard atmosphere over the geopotential height of mean sea level.

H = r h / (r + h),  r = 6 356 766 m
p = p₀ (T/T₀)^(−g M/(R L)) where the temperature changes by L per metre, p₁ e^(−g M (H − H₁)/(R T₁)) else
"""

from __future__ import annotations

import functools
import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

EARTH_RADIUS = 6_356_766.0
GRAVITY_OVER_GAS = 9.80665 * 0.0289644 / 8.31432
"""K/m: g M / R."""
STANDARD_HPA = 1013.25
LAYERS = (
    (0.0, 288.15, -0.0065),
    (11_000.0, 216.65, 0.0),
    (20_000.0, 216.65, 0.001),
    (32_000.0, 228.65, 0.0028),
)
"""Base m, temperature there K, its change K/m. The lowest goes on downwards, the last upwards."""


def standard_pressure(height: Floats) -> Floats:
    """Pa at heights above mean sea level, m."""
    geopotential = EARTH_RADIUS * height / (EARTH_RADIUS + height)
    _, lowest, pressure, temperature, change = _layers()[0]
    if (geopotential < lowest).all():
        return pressure * _ratio(geopotential, temperature, change)
    out = np.empty_like(geopotential)
    for base, ceiling, pressure, temperature, change in _layers():
        here = (geopotential >= base) & (geopotential < ceiling)
        above = geopotential[here] - (base if base > -math.inf else 0.0)
        out[here] = pressure * _ratio(above, temperature, change)
    return out


def pressure_height(pressure: Floats) -> Floats:
    """Its inverse; NaN for what is no pressure."""
    out = np.full_like(pressure, math.nan)
    for base, ceiling, bottom, temperature, change in _layers():
        start = base if base > -math.inf else 0.0
        most = math.inf if base == -math.inf else bottom
        least = (
            0.0
            if ceiling == math.inf
            else bottom * float(_ratio(np.array(ceiling - start), temperature, change))
        )
        here = (pressure <= most) & (pressure > least)
        ratio = pressure[here] / bottom
        if change:
            above = temperature / change * (ratio ** (-change / GRAVITY_OVER_GAS) - 1.0)
        else:
            above = -temperature / GRAVITY_OVER_GAS * np.log(ratio)
        geopotential = start + above
        out[here] = EARTH_RADIUS * geopotential / (EARTH_RADIUS - geopotential)
    return out


@functools.cache
def _layers() -> list[tuple[float, float, float, float, float]]:
    """Base, ceiling (m), pressure at the base (Pa), temperature there, its change."""
    found = []
    pressure = 100.0 * STANDARD_HPA
    for k, (base, temperature, change) in enumerate(LAYERS):
        last = k + 1 == len(LAYERS)
        ceiling = math.inf if last else LAYERS[k + 1][0]
        found.append((base if k else -math.inf, ceiling, pressure, temperature, change))
        if not last:
            pressure *= float(_ratio(np.array(ceiling - base), temperature, change))
    return found


def _ratio(above: Floats, temperature: float, change: float) -> Floats:
    """Pressure over that at the layer's base."""
    if change:
        lapsed: Floats = (1.0 + change * above / temperature) ** (-GRAVITY_OVER_GAS / change)
        return lapsed
    level: Floats = np.exp(-GRAVITY_OVER_GAS * above / temperature)
    return level
