"""After attitude was corrected by φ̂, what is left of its error is counted from the corrected attitude.

    φ ← (I − [φ̂×]/2) φ      first order; Markley, Attitude error representations for Kalman filtering,
    JGCD 26 (2003)

Three rows of U turn among one another and lose their triangular form. Behind the parameters' columns, which
simply turn, only three columns hold attitude: these are orthogonalised again (modified weighted Gram-Schmidt,
Thornton; Bierman 1977, ch. VI), the rows of position and velocity with them. In three columns three rows span
all there is, so nothing remains of them elsewhere. The Earth's rate turns the attitude error in the same way
(prediction).
"""

import numpy as np

from firmware.nav import layout as at
from firmware.numerics.dialect import kernel

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
N = np.int32(at.STATES)
THREE = np.int32(3)
FIRST = at.X_ATTITUDE
LAST = at.X_ATTITUDE + 2


@kernel
def turn_attitude_error(f, x, y, z):
    """φ → φ − (x, y, z) × φ in the covariance."""
    for j in range(np.int32(FIRST), N):
        u = at.U + j * at.STATES + FIRST
        if j <= LAST:
            for k in range(np.int32(j), np.int32(LAST + 1)):
                f[at.U + j * at.STATES + k] = ONE if k == j else ZERO
        a = f[u]
        b = f[u + 1]
        c = f[u + 2]
        f[u] = a - (y * c - z * b)
        f[u + 1] = b - (z * a - x * c)
        f[u + 2] = c - (x * b - y * a)
    for k in range(THREE):
        f[at.WEIGHT + k] = f[at.D + FIRST + k]
    for back in range(THREE):
        _orthogonalise(f, LAST - back)
    for j in range(np.int32(FIRST), np.int32(LAST + 1)):
        for k in range(np.int32(LAST + 1)):
            f[at.U + j * at.STATES + k] = f[at.TURNED + (j - FIRST) * (LAST + 1) + k]


@kernel
def _orthogonalise(f, k):
    """Column k of the new U (layout.TURNED) and its D from row k; what lies along it leaves the rows
    above."""
    a = at.U + FIRST * at.STATES
    b = a + at.STATES
    c = b + at.STATES
    wa = f[at.WEIGHT] * f[a + k]
    wb = f[at.WEIGHT + 1] * f[b + k]
    wc = f[at.WEIGHT + 2] * f[c + k]
    d = wa * f[a + k] + wb * f[b + k] + wc * f[c + k]
    f[at.D + k] = d
    scale = ONE / d if d > ZERO else ZERO
    out = at.TURNED + (k - FIRST) * (LAST + 1)
    for m in range(np.int32(LAST + 1)):
        f[out + m] = ZERO
    for m in range(np.int32(k)):
        u = scale * (wa * f[a + m] + wb * f[b + m] + wc * f[c + m])
        f[out + m] = u
        f[a + m] -= u * f[a + k]
        f[b + m] -= u * f[b + k]
        f[c + m] -= u * f[c + k]
