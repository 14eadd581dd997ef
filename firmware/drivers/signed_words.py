"""Signed numbers out of register bytes, in the kernel dialect."""

import numpy as np

from firmware.numerics.dialect import kernel


@kernel
def signed_16(low, high):
    """Two's complement of two bytes, as float32."""
    left = np.int32((np.int64(high) << 24) | (np.int64(low) << 16))
    return np.float32(np.int32(left >> 16))
