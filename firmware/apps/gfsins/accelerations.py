"""From what seven chips say to nine accelerations in the packet: scale and offset, in whole numbers."""

import numpy as np

from firmware.drivers.adxl345_sample import SAMPLE_LENGTH
from firmware.nav.gyro_free import packet as pk
from firmware.numerics.dialect import kernel

CHIPS = 7
NINE = np.int32(9)
SHIFT = np.int64(16)
HALF = np.int64(1 << 15)
NOMINAL_SCALE = 512_000
"""Words of 0.5 mg a count of 1/256 g, in units of 2⁻¹⁶: 7.8125."""
LARGEST = np.int64(32767)
LOW = np.int64(0xFFFF)
SIGN = np.int64(0x8000)
FARTHEST = np.int64(1000)
"""0.5 g: at the end of an arm of 0.25 m it would be 20 rad/s²."""
ARMS = np.int32(6)
ONE = np.int64(1)
SEVEN = np.int32(CHIPS)
SAMPLE_BYTES = np.int32(SAMPLE_LENGTH - 1)
KNOWN = np.uint8(1)


@kernel("int64(uint8[::1], int64[::1], int64[::1], int64[::1])")
def fill_accelerations(raw, scales, offsets, words):
    """`raw`: a sample of each chip as its driver has it, one after the other. A1 … A6 are x, y, z, x, y, z of
    chips 1 … 6, A7 … A9 the three of chip 7. `offsets` in words. Returns bits of the chips on arms that
    differ more from that at the origin than any vehicle could turn them."""
    for k in range(NINE):
        chip = k if k < CHIPS - 1 else CHIPS - 1
        place = chip * SAMPLE_LENGTH + 1 + 2 * (k % 3)
        count = ((np.int64(raw[place + 1]) << 8) | np.int64(raw[place])) ^ SIGN
        value = (((count - SIGN) * scales[k] + HALF) >> SHIFT) - offsets[k]
        words[pk.ACCELERATIONS + k] = max(-LARGEST, min(LARGEST, value)) & LOW
    far = np.int64(0)
    for k in range(ARMS):
        arm = words[pk.ACCELERATIONS + k]
        origin = words[pk.ACCELERATIONS + 6 + k % 3]
        if abs((arm ^ SIGN) - (origin ^ SIGN)) > FARTHEST:
            far |= ONE << k
    return far


@kernel("int64(uint8[::1], uint8[::1], int64)")
def compare_samples(raw, before, fresh):
    """Bits of those chips of `fresh` whose sample is that of the time before. `before` keeps it, behind a
    byte that says whether there is one."""
    alike = np.int64(0)
    for chip in range(SEVEN):
        place = chip * SAMPLE_LENGTH
        if (fresh >> chip) & ONE:
            same = before[place] == KNOWN
            before[place] = KNOWN
            for k in range(SAMPLE_BYTES):
                if before[place + 1 + k] != raw[place + 1 + k]:
                    same = False
                    before[place + 1 + k] = raw[place + 1 + k]
            if same:
                alike |= ONE << chip
    return alike
