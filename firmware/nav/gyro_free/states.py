"""Which states of the navigation core the gyro-free filters use, and as what.

    0  δr   3  δv   6  φ   9  δb_g (the document's ε)   12  δb_a (∇)      common, 15
    15 error of the compass, rad, NED, first-order Gauss-Markov               18 with it

The core's states 15 … 17 are the correlated error of an aid: of a receiver's position elsewhere, of the
compass here. The GPS filter has none. All other states of the core are off: no variance, no noise.
"""

from firmware.nav import layout as at

COMMON = at.X_GNSS_ERROR
ALL = COMMON + 3
X_COMPASS_ERROR = at.X_GNSS_ERROR
COMPASS_ERROR = at.GNSS_ERROR
"""Its estimate in `f`."""
