"""All that a tick puts into its packet, in one call: accelerations, header, marks, checksum."""

import numpy as np

from firmware.apps.gfsins.accelerations import fill_accelerations
from firmware.nav.gyro_free import packet as pk
from firmware.numerics.dialect import kernel

LOW = np.int64(0xFFFF)


@kernel("void(uint8[::1], int64[::1], int64[::1], int64[::1], uint8[::1], int64, int64, int64, int64, int64)")
def fill_packet(raw, scales, offsets, words, data, sequence, tick_us, fresh, faults, flags):
    """`words` become those of tick `tick_us`, `data` what is sent. A chip on an arm that is far from that at
    the origin counts among the `faults`."""
    far = fill_accelerations(raw, scales, offsets, words)
    words[pk.SEQUENCE] = sequence
    words[pk.TIME] = tick_us >> 32
    words[pk.TIME + 1] = (tick_us >> 16) & LOW
    words[pk.TIME + 2] = tick_us & LOW
    words[pk.CHIPS] = fresh
    words[pk.FAULTS] = faults | far
    words[pk.FLAGS] = flags
    pk.seal_packet(words, data)
