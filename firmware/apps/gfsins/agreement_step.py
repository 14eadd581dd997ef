"""Which of seven accelerometers is far from what the others feel: the arithmetic behind `agreement`."""

import numpy as np

from firmware.apps.gfsins.accelerations import CHIPS
from firmware.drivers.adxl345_sample import SAMPLE_LENGTH
from firmware.numerics.dialect import kernel

AXES = 3
FARTHEST = 102 << 8
"""0.4 g, in 1/256 of a count: offsets of two chips (0.15 g each) and 10 % of sensitivity."""
BEGUN = CHIPS * AXES
WORK = BEGUN + 1
SIZE = WORK + CHIPS
SIGN = np.int64(0x8000)
ONE = np.int64(1)


@kernel("int64(uint8[::1], int64, int64[::1])")
def chips_far_off(raw, known, means):
    """Bits of those that are far from the median, after the means have taken the newest samples in.

    `raw`: a sample of each chip as its driver has it; `known`: bits of the chips that are compared;
    `means`: SIZE numbers, at first zeros."""
    for chip in range(np.int32(CHIPS)):
        for axis in range(np.int32(AXES)):
            place = chip * SAMPLE_LENGTH + 1 + 2 * axis
            count = ((np.int64(raw[place + 1]) << 8) | np.int64(raw[place])) ^ SIGN
            value = (count - SIGN) << 8
            k = chip * AXES + axis
            means[k] = value if means[BEGUN] == 0 else means[k] + ((value - means[k]) >> 2)
    means[BEGUN] = ONE
    far = np.int64(0)
    for axis in range(np.int32(AXES)):
        far |= _far_along(known, means, axis)
    return far


@kernel
def _far_along(known, means, axis):
    """The same along one axis; none when fewer than three chips are known."""
    count = np.int32(0)
    for chip in range(np.int32(CHIPS)):
        if (known >> chip) & ONE != 0:
            value = means[chip * AXES + axis]
            k = count
            while k > 0 and means[WORK + k - 1] > value:
                means[WORK + k] = means[WORK + k - 1]
                k -= 1
            means[WORK + k] = value
            count += 1
    far = np.int64(0)
    if count < AXES:
        return far
    middle = means[WORK + (count >> 1)]
    for chip in range(np.int32(CHIPS)):
        if (known >> chip) & ONE != 0 and abs(means[chip * AXES + axis] - middle) > FARTHEST:
            far |= ONE << chip
    return far
