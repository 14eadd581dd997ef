"""The course of one run on a common time base, small enough to keep a thousand of them.

101 instants from start to end. An instant takes the nearest value within half a step, and none (NaN) where
there is none: before alignment, or between the covariances that count.
"""

from __future__ import annotations

import base64
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from host.record.result import RunResult
from host.record.run_data import NAVIGATING
from host.record.series import DecimatedSeries

Floats = NDArray[np.float64]

INSTANTS = 101

ERRORS = (
    *("error_north_m", "error_east_m", "error_down_m"),
    *("error_v_north_mps", "error_v_east_mps", "error_v_down_mps"),
    *("error_roll_deg", "error_pitch_deg", "error_yaw_deg"),
)
SIGMAS = (
    *("sigma_north_m", "sigma_east_m", "sigma_down_m"),
    *("sigma_v_north_mps", "sigma_v_east_mps", "sigma_v_down_mps"),
    *("sigma_psi_n_deg", "sigma_psi_e_deg", "sigma_psi_d_deg"),
)
INNOVATIONS = ("north_m", "east_m", "down_m", "v_north_mps", "v_east_mps", "v_down_mps")
NORMALISED = tuple(f"normalised_{name}" for name in INNOVATIONS)
"""Innovations divided by their own σ of the filter; of those that it used."""
NEES = "nees"
COLUMNS = (*ERRORS, *SIGMAS, NEES, *NORMALISED)


def instants(duration_s: float) -> Floats:
    """The common time base, s."""
    return np.linspace(0.0, duration_s, INSTANTS)


def course(result: RunResult) -> dict[str, Any]:
    """The series of a run as JSON holds it; nothing when the run was not recorded."""
    data = result.data
    if data is None:
        return {}
    wanted = instants(result.duration_s)
    found = np.full((len(COLUMNS), INSTANTS), np.nan)
    navigating = data.solution.column("mode") >= NAVIGATING
    t = data.solution.column("t_s")
    for place, name in enumerate((*ERRORS, *SIGMAS)):
        values = np.where(navigating, data.solution.column(name), np.nan)
        found[place] = _nearest(t, values, wanted)
    found[COLUMNS.index(NEES)] = _nearest(data.nees.column("t_s"), data.nees.column("nees"), wanted)
    for place, name in enumerate(INNOVATIONS):
        values = _normalised(data.innovations, place, name)
        found[COLUMNS.index(NORMALISED[place])] = _nearest(data.innovations.column("t_s"), values, wanted)
    packed = base64.b64encode(found.astype("<f4").tobytes()).decode()
    return {"duration_s": result.duration_s, "columns": list(COLUMNS), "float32": packed}


def unpacked(series: Mapping[str, Any]) -> dict[str, Floats]:
    """The columns of a run's series, each with INSTANTS values."""
    names = series["columns"]
    flat = np.frombuffer(base64.b64decode(series["float32"]), dtype="<f4").astype(np.float64)
    return dict(zip(names, flat.reshape(len(names), -1), strict=True))


def _normalised(innovations: DecimatedSeries, place: int, name: str) -> Floats:
    used = innovations.column("used").astype(np.int64) >> place & 1 == 1
    sigma = innovations.column(f"sigma_{name}")
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(used & (sigma > 0), innovations.column(name) / sigma, np.nan)


def _nearest(t: Floats, values: Floats, wanted: Floats) -> Floats:
    """The value nearest to each wanted instant, NaN where none is within half a step."""
    if len(t) == 0:
        return np.full(len(wanted), np.nan)
    after = np.clip(np.searchsorted(t, wanted), 0, len(t) - 1)
    before = np.maximum(after - 1, 0)
    chosen = np.where(np.abs(t[before] - wanted) <= np.abs(t[after] - wanted), before, after)
    half_step = (wanted[1] - wanted[0]) / 2
    return np.where(np.abs(t[chosen] - wanted) <= half_step, values[chosen], np.nan)
