"""Whether this process computes with subnormal numbers, as the target does.

A library built for speed may switch the processor to flush them to zero when it is loaded; results then
differ in their last bits from those of the board and of other runs.
"""

import numpy as np

SMALLEST_NORMAL = np.float32(1.1754944e-38)
HALF = np.float32(0.5)
ZERO = np.float32(0.0)


def check_subnormals() -> None:
    """RuntimeError when this thread flushes subnormal numbers to zero."""
    half = SMALLEST_NORMAL * HALF
    if not (half > ZERO and half + half == SMALLEST_NORMAL):
        raise RuntimeError(
            "this process flushes subnormal numbers to zero, so results are not those of the board; "
            "a library loaded before (one built with -ffast-math, say) has switched the processor"
        )
