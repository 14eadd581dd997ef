"""What a filter made of a recording, and our filter fed directly."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from firmware.nav.drift import layout as at
from firmware.nav.drift.fixed import settings as fixed
from firmware.nav.drift.fixed.fusion import step as fixed_step
from firmware.nav.drift.settings import DriftSettings, new_state
from firmware.numerics.dialect import entry_point
from firmware.numerics.precision import load
from host.attitude.recording import AttitudeRecording
from host.attitude.scoring import east_north_up

Floats = NDArray[np.float64]

FIXED: Final = "fixed"
ARITHMETICS: Final = ("float32", FIXED, "float64")
TESLA_PER_MICROTESLA: Final = 1.0e-6


class UnsupportedRateError(Exception):
    """A filter does not work at a recording's sample rate."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """Attitude at the times of a recording's samples."""

    quaternions: Floats
    """(n, 4), sensor to east-north-up."""
    saturated: NDArray[np.bool_] | None = None
    """(n,): gyros beyond their range since the sample before; None when nobody looked."""
    samples: int = 0
    """That the filter was fed."""


def by_drift_filter(
    recording: AttitudeRecording, settings: DriftSettings, arithmetic: str = "float32"
) -> Estimate:
    """Our filter, fed with the recording's samples as they are.

    UnsupportedRateError when the fixed-point filter does not work at the recording's rate.
    """
    if arithmetic == FIXED:
        return _in_fixed_point(recording, settings)
    rows = np.column_stack(
        (np.full(len(recording), recording.interval), recording.omega, recording.force, recording.field)
    )
    quaternions, flags = run_filter(rows, settings, arithmetic)
    return Estimate(east_north_up(quaternions), (flags & at.SATURATED) != 0, len(rows))


def run_filter(
    rows: Floats, settings: DriftSettings, arithmetic: str = "float32"
) -> tuple[Floats, NDArray[np.int64]]:
    """Attitudes q_nb (n, 4) and flags (n,) after each of the samples (n, layout.SAMPLE_SIZE)."""
    dtype = np.dtype(arithmetic)
    step = entry_point(load("firmware.nav.drift.fusion", arithmetic).step)
    d, k = new_state(settings, dtype)
    with np.errstate(over="ignore"):  # what is too large for float32 is no number to the filter either
        samples = np.ascontiguousarray(rows, dtype)
    quaternions = np.empty((len(rows), 4))
    flags = np.empty(len(rows), np.int64)
    attitude = d[at.Q_NB : at.Q_NB + 4]
    for row in range(len(rows)):
        step(d, k, samples[row])
        quaternions[row] = attitude
        flags[row] = k[at.FLAGS]
    return quaternions, flags


def _in_fixed_point(recording: AttitudeRecording, settings: DriftSettings) -> Estimate:
    try:
        d, k = fixed.new_state(recording.interval, settings)
    except ValueError as error:
        raise UnsupportedRateError(f"{recording.name}: fixed point left out: {error}") from None
    step = entry_point(fixed_step)
    field = recording.field * TESLA_PER_MICROTESLA
    samples = fixed.samples(np.column_stack((recording.omega, recording.force, field)))
    quaternions = np.empty((len(samples), 4))
    flags = np.empty(len(samples), np.int64)
    for row in range(len(samples)):
        step(d, k, samples[row])
        quaternions[row] = fixed.attitude(d)
        flags[row] = k[at.FLAGS]
    return Estimate(east_north_up(quaternions), (flags & at.SATURATED) != 0, len(samples))
