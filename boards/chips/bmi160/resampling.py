"""Array helpers of the sampler: running means over past samples, and holding a slower sensor's registers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from boards.chips.bmi160.settings import Stream


def running_mean(past: NDArray[np.float64], values: NDArray[np.float64], window: int) -> NDArray[np.float64]:
    """Mean of each row of `values` and the window−1 rows before it, the first of them in `past`.

    Where fewer rows exist the mean runs over those.
    """
    if window == 1:
        return values
    lead = min(len(past), window - 1)
    rows = np.concatenate((past[len(past) - lead :], values))
    sums = np.concatenate((np.zeros((1, rows.shape[1])), np.cumsum(rows, axis=0)))
    last = np.arange(lead, len(rows))
    first = np.maximum(last - window + 1, 0)
    mean: NDArray[np.float64] = (sums[last + 1] - sums[first]) / (last + 1 - first)[:, None]
    return mean


def hold(octets: NDArray[np.uint8], stream: Stream | None, first_tick: int, grid: int, before: bytes) -> None:
    """Replace rows of a register image (n, 6) at which a sensor has no sample by its newest sample.

    Row i lies at sensor time first_tick + i·grid; `before` stood in the registers before the first row.
    """
    held = np.frombuffer(before, np.uint8)
    if stream is None:
        octets[:] = held
        return
    ticks = first_tick + np.arange(len(octets), dtype=np.int64) * grid
    newest = (ticks - ticks % stream.period - first_tick) // grid
    octets[:] = np.where((newest < 0)[:, None], held, octets[np.maximum(newest, 0)])
