"""What becomes of the averages when an angle was lost: gyros saturated, samples missing.

Means of the past hold for the attitude as it was. With an attitude now uncertain by σ they are worth as much
as a mean over T₀ = T_c (σ_m/σ)², where one measurement scatters by σ_m and is independent of another after
T_c: of force 0.2 rad (hands move at 2 m/s²) and 0.3 s, of the magnetic field 0.05 rad and 0.3 s.
"""

import numpy as np

from firmware.nav.drift import layout as at
from firmware.numerics.dialect import kernel

ZERO = np.float32(0.0)
SMALLEST = np.float32(0.01)
"""rad: less is not worth starting again."""
SHORTEST = np.float32(0.01)
FORCE_WORTH = np.float32(0.012)
FIELD_WORTH = np.float32(0.00075)
"""T_c σ_m², rad² s."""
PAUSE = np.float32(6.0)


@kernel
def lose(d, k, sigma):
    """The attitude has become uncertain by sigma, rad."""
    if not sigma > SMALLEST:
        return
    square = sigma * sigma
    d[at.FORCE_AGE] = min(d[at.FORCE_AGE], max(FORCE_WORTH / square, SHORTEST))
    d[at.HEADING_AGE] = min(d[at.HEADING_AGE], max(FIELD_WORTH / square, SHORTEST))
    d[at.BIAS_PAUSE] = PAUSE
    k[at.LOSSES] += 1
