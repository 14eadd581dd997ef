"""Groups of scalar measurements that are accepted or refused together.

A group of n ≤ 3 rows is consistent when its innovation ν weighs no more than a χ² threshold,
ν' S⁻¹ ν ≤ γ, S = H P H' + R, R diagonal. S is factored in place (Cholesky).
"""

import math

import numpy as np

from firmware.nav import layout as at
from firmware.nav.covariance import absorb_projected, project, projected_product, remaining_residual
from firmware.numerics.dialect import kernel

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
N = np.int32(at.STATES)


@kernel
def clear_rows(f):
    """All six measurement rows zero."""
    for k in range(np.int32(at.ROW_LIMIT * at.STATES)):
        f[at.ROWS + k] = ZERO


@kernel
def weigh_group(f, first, count):
    """ν' S⁻¹ ν of rows first … first + count − 1; √S of each goes to layout.INNOVATION_SIGMA."""
    for a in range(np.int32(count)):
        row = first + a
        project(f, row)
        for b in range(np.int32(a + 1)):
            s = projected_product(f, row, first + b)
            if a == b:
                s += f[at.VARIANCE + row]
                f[at.INNOVATION_SIGMA + row] = np.float32(math.sqrt(s))
            f[at.TRIANGLE + 3 * a + b] = s
    total = ZERO
    for a in range(np.int32(count)):
        weighted = f[at.RESIDUAL + first + a]
        for b in range(np.int32(a + 1)):
            s = f[at.TRIANGLE + 3 * a + b]
            for k in range(np.int32(b)):
                s -= f[at.TRIANGLE + 3 * a + k] * f[at.TRIANGLE + 3 * b + k]
            if a == b:
                # rounding only could bring this to zero: each S holds a variance
                f[at.TRIANGLE + 3 * a + a] = np.float32(math.sqrt(s)) if s > ZERO else ONE
            else:
                f[at.TRIANGLE + 3 * a + b] = s / f[at.TRIANGLE + 3 * b + b]
                weighted -= f[at.TRIANGLE + 3 * a + b] * f[at.TRIANGLE + 9 + b]
        weighted /= f[at.TRIANGLE + 3 * a + a]
        f[at.TRIANGLE + 9 + a] = weighted
        total += weighted * weighted
    return total


@kernel
def absorb_group(f, first, count):
    """Update by the rows one after the other; the estimated error gathers in layout.CORRECTION."""
    for a in range(np.int32(count)):
        project(f, first + a)
        absorb_projected(f, first + a)


@kernel
def absorb_if_plausible(f, row, gate):
    """Update by one scalar if its innovation, given those absorbed before, passes the gate; whether it
    did."""
    project(f, row)
    s = projected_product(f, row, row) + f[at.VARIANCE + row]
    residual = remaining_residual(f, row)
    if not residual * residual <= gate * s:
        return False
    absorb_projected(f, row)
    return True
