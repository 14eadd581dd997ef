"""The loops over a block of samples, compiled: filter, counts, image of a burst, flags of ranges.

Rows are samples; columns of physical values are those of the world (`boards.chips.world.TenDofWorld`),
columns of counts are the outputs in burst order.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

OUTPUTS: Final = 14
COLUMNS: Final = 11
"""Of the world."""
UNFILTERED: Final = (6, 10)
"""Those of them that do not go through the filter: temperature, pressure."""
USUAL_TAPS: Final = 4
WORLD_OF: Final = np.array((-1, 3, 4, 5, 0, 1, 2, 7, 8, 9, 10, 10, 6, -1), np.int64)
"""Of each output the column of the world; −1: a voltage."""
BARO: Final = 10
LOW_COUNTS: Final = 256.0
"""Steps of BARO_OUTL in one of BARO_OUT."""
MOST_PRESSURE: Final = float((1 << 22) - 1)
FURTHEST: Final = 1.0e6
"""Counts are bounded here before they become integers; every output ends far below."""


@njit(cache=True, error_model="numpy", inline="always")
def filter_rows(raw: Floats, taps: int, scaled: Floats, stage: Floats, out: Floats) -> None:
    """The body of `filter_block`; sums go row by row, so that all columns of a row are worked off at once."""
    n = raw.shape[0]
    share = 1.0 / taps
    for row in range(n):
        for column in range(COLUMNS):
            scaled[row, column] = raw[row, column] * share
    for row in range(n + taps - 1):
        for column in range(COLUMNS):
            total = 0.0
            for back in range(taps):
                total += scaled[max(0, row - (taps - 1) - back), column]
            stage[row, column] = total * share
    for row in range(n):
        for column in range(COLUMNS):
            total = 0.0
            for back in range(taps):
                total += stage[row + (taps - 1) - back, column]
            out[row, column] = total
        for column in UNFILTERED:
            out[row, column] = raw[row, column]


@njit(cache=True, error_model="numpy")
def filter_block(raw: Floats, taps: int, scaled: Floats, stage: Floats, out: Floats) -> None:
    """Two cascaded boxcar means of `taps`; before its first value the signal stood at it.

    `scaled`, `stage`: room for n and for n + taps − 1 rows. The four taps of power-on have code of their own,
    with all loops over them unrolled.
    """
    if taps == USUAL_TAPS:
        filter_rows(raw, USUAL_TAPS, scaled, stage, out)
    else:
        filter_rows(raw, taps, scaled, stage, out)


@njit(cache=True, error_model="numpy")
def count_block(values: Floats, gain: Floats, offset: Floats, counts: Integers) -> None:
    """counts = round(value · gain + offset), not yet clipped; pressure is rounded as one number."""
    for row in range(values.shape[0]):
        for output in range(OUTPUTS):
            column = WORLD_OF[output]
            exact = offset[output]
            if column >= 0:
                exact += values[row, column] * gain[output]
            counts[row, output] = np.int64(np.rint(min(max(exact, -FURTHEST), FURTHEST)))
        pressure = np.rint(values[row, 10] * gain[BARO])
        whole = np.int64(min(max(pressure, 0.0), MOST_PRESSURE))
        counts[row, BARO] = whole >> 8
        counts[row, BARO + 1] = whole & 255


@njit(cache=True, error_model="numpy")
def image_block(
    counts: Integers, low: Integers, high: Integers, mask: Integers, bits: int, image: NDArray[np.uint8]
) -> None:
    """Words as they come in a burst, high byte first, `bits` set in each."""
    place = 0
    for row in range(counts.shape[0]):
        for output in range(OUTPUTS):
            value = min(max(counts[row, output], low[output]), high[output])
            word = (value & mask[output]) | bits
            image[place] = word >> 8
            image[place + 1] = word & 255
            place += 2


@njit(cache=True, error_model="numpy")
def range_block(raw: Floats, low: Floats, high: Floats, flag: int, flags: Integers) -> None:
    """`flag` for every sample with a value outside of `low` … `high` of its column."""
    for row in range(raw.shape[0]):
        flags[row] = 0
        for column in range(raw.shape[1]):
            if raw[row, column] < low[column] or raw[row, column] > high[column]:
                flags[row] = flag
