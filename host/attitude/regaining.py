"""After saturation: how long until the attitude is right again.

Saturated samples less than half a second apart are one episode. An episode is regained when the total error
is below 5° for the first time after its end, before the next episode begins; samples without a reference
are not looked at.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from host.attitude.scoring import Floats

LIMIT_DEG = 5.0
APART_S = 0.5


@dataclass(frozen=True, slots=True)
class Regaining:
    """What saturation did."""

    samples: int
    """Recorded samples during which a gyro was saturated."""
    episodes: int
    regained: int
    """Episodes after which the error came below 5°."""
    longest_s: float | None
    """Of those: the longest time that it took. None when there is none."""
    after_last_s: float | None
    """After the last episode; None when it never did, or there was none."""


def regaining(saturated: NDArray[np.bool_], total_deg: Floats, interval: float) -> Regaining:
    """From flags and errors of every sample (n,)."""
    at = np.flatnonzero(saturated)
    if not len(at):
        return Regaining(0, 0, 0, None, None)
    breaks = np.flatnonzero(np.diff(at) * interval > APART_S)
    ends = at[np.append(breaks, len(at) - 1)]
    next_begins = np.append(at[breaks + 1], len(saturated))
    times = [
        _first_below(total_deg[end:begin], interval) for end, begin in zip(ends, next_begins, strict=True)
    ]
    done = [time for time in times if time is not None]
    return Regaining(len(at), len(ends), len(done), max(done, default=None), times[-1])


def _first_below(total_deg: Floats, interval: float) -> float | None:
    below = np.flatnonzero(total_deg < LIMIT_DEG)
    return float(below[0] * interval) if len(below) else None
