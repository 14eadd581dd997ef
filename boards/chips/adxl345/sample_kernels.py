"""The loops over a block of samples, compiled: physical values to g, decimation, and g to register bytes.

They run also interpreted (NUMBA_DISABLE_JIT=1) with the same results.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

STRIDE: Final = 7
"""Bytes of a sample in a block: a zero (what the bus shows during the address byte), then DATAX0 … DATAZ1."""


@njit(cache=True, error_model="numpy")
def fill_g(
    values: NDArray[np.float64],
    response: NDArray[np.float64],
    ticks: NDArray[np.int64],
    g: NDArray[np.float64],
) -> None:
    """Specific force (n, ≥ 3) in m/s² into g (n, 3) as the sensor gives it.

    response (4, 3): scale, bias, deflection before, deflection after a switch of the self-test.
    ticks: of the first value, between values, of the switch, and how long the deflection takes.
    """
    first, step, since, ramp = ticks[0], ticks[1], ticks[2], ticks[3]
    for i in range(len(values)):
        part = min(max((first + i * step - since) / ramp, 0.0), 1.0)
        for axis in range(3):
            deflection = response[2, axis] + part * (response[3, axis] - response[2, axis])
            g[i, axis] = values[i, axis] * response[0, axis] + response[1, axis] + deflection


@njit(cache=True, error_model="numpy")
def fill_means(
    past: NDArray[np.float64], g: NDArray[np.float64], window: int, mean: NDArray[np.float64]
) -> None:
    """The mean of each row of g (n, 3) and the window−1 rows before it, the first of them in `past`; of those
    that there are."""
    lead = len(past)
    for i in range(len(g)):
        first = max(i - window + 1, -lead)
        for axis in range(3):
            total = 0.0
            for k in range(first, i + 1):
                total += g[k, axis] if k >= 0 else past[lead + k, axis]
            mean[i, axis] = total / (i - first + 1)


@njit(cache=True, error_model="numpy")
def fill_words(
    g: NDArray[np.float64],
    rows: NDArray[np.int64],
    counts_per_g: float,
    form: NDArray[np.int64],
    words: NDArray[np.uint8],
) -> None:
    """Rows rows[0], rows[0] + rows[1] … of g (n, 3) into words (m, 7): counts, clipped, low byte first.

    form: lowest and highest count, mask, shift to the left.
    """
    low, high, mask, shift = form[0], form[1], form[2], form[3]
    for k in range(len(words)):
        i = rows[0] + k * rows[1]
        words[k, 0] = 0
        for axis in range(3):
            counts = np.rint(g[i, axis] * counts_per_g)
            word = (int(min(max(counts, float(low)), float(high))) & mask) << shift
            words[k, 1 + 2 * axis] = word & 0xFF
            words[k, 2 + 2 * axis] = (word >> 8) & 0xFF
