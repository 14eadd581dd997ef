"""Does a GNSS epoch come at the time it says? Its time of day must run with the board clock.

After a jump, epochs are ignored until some in a row agree with one another again.
"""

import numpy as np

from firmware.drivers import gnss_epoch as gnss
from firmware.nav import layout as at
from firmware.nav import tuning as cfg
from firmware.nav.flags import GNSS_TIME_JUMP, report
from firmware.numerics.dialect import kernel

NS_PER_MS = np.int64(1_000_000)
DAY_MS = np.int64(86_400_000)
HALF_DAY_MS = np.int64(43_200_000)


@kernel
def time_is_believed(i, e):
    """Whether the time of day moved like the board clock since the epoch before; True without a time."""
    if not e[gnss.FLAGS] & gnss.HAS_TIME:
        return True
    first = i[at.EPOCH_VALID] == at.NEVER
    told = e[gnss.TIME_OF_DAY_MS] - i[at.EPOCH_TIME_OF_DAY]
    passed = e[gnss.VALID_NS] - i[at.EPOCH_VALID]
    i[at.EPOCH_TIME_OF_DAY] = e[gnss.TIME_OF_DAY_MS]
    i[at.EPOCH_VALID] = e[gnss.VALID_NS]
    if first:
        return True
    if told < -HALF_DAY_MS:
        told += DAY_MS
    if abs(told * NS_PER_MS - passed) > i[cfg.TIME_JUMP_NS]:
        i[at.EPOCHS_TO_WAIT] = i[cfg.EPOCHS_AFTER_JUMP]
        report(i, GNSS_TIME_JUMP)
        return False
    if i[at.EPOCHS_TO_WAIT] > 0:
        i[at.EPOCHS_TO_WAIT] -= 1
        return False
    return True
