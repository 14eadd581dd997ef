"""Allan deviation of inertial samples, by allantools, and the noise coefficients that make such a curve.

The curve is the overlapping Allan deviation. To its square the sum

    σ²(τ) = 3 Q²/τ² + N²/τ + GM(τ; σ_b, T) + K² τ/3 + R² τ²/2
    GM    = 2 σ_b² T/τ (1 − (3 − 4 e^(−τ/T) + e^(−2τ/T)) T/(2τ))

is fitted with terms that are not negative (non-negative least squares on the relative error, weighted by the
number of intervals that a point rests on), T scanned. N is the random walk (of angle or velocity; a
single-sided density n gives n/√2), B = min σ / 0.664 the bias instability of data sheets. IEEE Std 952-1997,
annex C.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import allantools
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

Floats = NDArray[np.float64]

POINTS_PER_DECADE = 12
LONGEST_SHARE = 9
"""The longest averaging time is this part of the record: beyond, a handful of intervals tells nothing."""
FLICKER = math.sqrt(2.0 * math.log(2.0) / math.pi)
"""σ of flicker noise with B = 1."""
CORRELATION_TIMES = 40


@dataclass(frozen=True, slots=True)
class Coefficients:
    """Of one axis, in SI (rad/s or m/s²)."""

    random_walk: float
    """N, per √Hz."""
    bias_instability: float
    """B."""
    at_s: float
    """Where the curve is lowest."""
    markov: float
    """σ_b of the Gauss–Markov part; 0: there is none."""
    markov_time_s: float
    rate_random_walk: float
    """K, per √s."""
    rate_ramp: float
    """R, per s."""
    quantisation: float
    """Q, times s."""
    worst_misfit: float
    """Largest relative difference between curve and fit."""


@dataclass(frozen=True, slots=True)
class Curve:
    """One axis."""

    name: str
    tau_s: Floats
    deviation: Floats
    fit: Floats
    coefficients: Coefficients


def curve_of(name: str, values: Floats, rate_hz: float) -> Curve:
    """The curve of samples (rates, not increments) and what it is made of."""
    duration = len(values) / rate_hz
    longest = duration / LONGEST_SHARE
    count = max(4, int(POINTS_PER_DECADE * math.log10(longest * rate_hz)))
    steps = np.unique(np.round(np.geomspace(1.0, longest * rate_hz, count)).astype(np.int64))
    tau, deviation, _, _ = allantools.oadev(
        values - values.mean(), rate=rate_hz, data_type="freq", taus=steps / rate_hz
    )
    tau, deviation = np.asarray(tau), np.asarray(deviation)
    good = deviation > 0.0
    tau, deviation = tau[good], deviation[good]
    coefficients, fit = identified(tau, deviation, duration)
    return Curve(name, tau, deviation, fit, coefficients)


def identified(tau: Floats, deviation: Floats, duration_s: float) -> tuple[Coefficients, Floats]:
    """What a curve is made of, and the curve that this makes."""
    weight = np.sqrt(np.maximum(duration_s / tau - 1.0, 1.0))
    best: tuple[float, Any, float, Floats] | None = None
    for time_s in np.geomspace(max(1.0, 3.0 * tau[0]), max(10.0, 3.0 * tau[-1]), CORRELATION_TIMES).tolist():
        terms = _terms(tau, time_s)
        scaled = terms / deviation[:, None] ** 2 * weight[:, None]
        size = np.linalg.norm(scaled, axis=0)
        squares, _ = nnls(scaled / size, weight)
        squares = squares / size
        fit = np.sqrt(terms @ squares)
        cost = float(np.sum((weight * np.log(fit / deviation)) ** 2))
        if best is None or cost < best[0]:
            best = cost, squares, time_s, fit
    assert best is not None
    _, squares, time_s, fit = best
    quantisation, white, markov, walk, ramp = np.sqrt(squares).tolist()
    lowest = int(np.argmin(deviation))
    found = Coefficients(
        random_walk=white,
        bias_instability=float(deviation[lowest]) / FLICKER,
        at_s=float(tau[lowest]),
        markov=markov,
        markov_time_s=time_s if markov > 0.0 else 0.0,
        rate_random_walk=walk,
        rate_ramp=ramp,
        quantisation=quantisation,
        worst_misfit=float(np.max(np.abs(fit / deviation - 1.0))),
    )
    return found, fit


def _terms(tau: Floats, time_s: float) -> Floats:
    x = tau / time_s
    markov = 2.0 / x * (1.0 - (3.0 - 4.0 * np.exp(-x) + np.exp(-2.0 * x)) / (2.0 * x))
    return np.column_stack((3.0 / tau**2, 1.0 / tau, markov, tau / 3.0, tau**2 / 2.0))


@dataclass(frozen=True, slots=True)
class Record:
    """Samples at rest."""

    rate_hz: float
    channels: dict[str, Floats]
    """By name; `gyro_x` … in rad/s, `accel_x` … in m/s²."""
    source: Path
