"""When was a sample taken: the chip's own sample clock, locked to the processor's.

The BMI160 samples on its own oscillator, half a percent off. Its sensortime (24 bits, 39.0625 µs a tick)
says which sample was read, the processor's clock when it was read, some microseconds of interrupt
latency later. A second-order loop joins the two: sensortime carries the sample number without jitter,
the loop learns the length of a tick on the processor's clock.

    t⁻ = t + n·τ        n ticks since the last sample, τ the length of a tick
    e  = t_read − t⁻
    t⁺ = t⁻ + e/16,     τ⁺ = τ + e/(512·256)

State, int64: LAST ticks of the last sample (−1: none yet), TIME ns on the processor's clock,
TICK length of a tick in 2⁻¹⁶ ns, MISSED samples never read, REPEATED samples read twice.
"""

import numpy as np

from firmware.numerics.dialect import kernel

LAST, TIME, TICK, MISSED, REPEATED = 0, 1, 2, 3, 4
CLOCK_SIZE = 5

TICKS_PER_SAMPLE = np.int64(256)
"""At 100 Hz; bit 8 of the sensortime toggles with the sample clock (fact sheet section 7)."""
SAMPLE_MASK = np.int64(0xFFFF00)
FRACTION_MASK = np.int64(0xFF)
WRAP_MASK = np.int64(0xFFFFFF)
NOMINAL_TICK = np.int64(39_062_5 * 65_536 // 10)
"""39.0625 µs in 2⁻¹⁶ ns."""
LOST_LOCK_NS = np.int64(3_000_000)
LONGEST_GAP = np.int64(256 * 100)
"""Ticks; after a second without a sample the loop starts again."""


def reset_clock(s, at):
    """Forget the lock (plain Python, at set-up and after a reset of the chip)."""
    s[at + LAST] = -1
    s[at + TIME] = 0
    s[at + TICK] = NOMINAL_TICK


@kernel("int64(int64[::1], int32, int64, int64)")
def sample_time(s, at, ticks, t_read_ns):
    """Advance to the sample read at `t_read_ns` with the sensortime `ticks`.

    Returns the time since the previous sample in ns: 0 when the same sample was read again, −1 when the
    loop has just (re)started and there is no previous sample. `s[at + TIME]` is then the sample's time.
    """
    sample = ticks & SAMPLE_MASK
    read = t_read_ns - (((ticks & FRACTION_MASK) * s[at + TICK]) >> np.int64(16))
    last = s[at + LAST]
    n = (sample - last) & WRAP_MASK
    if last < np.int64(0) or n > LONGEST_GAP:
        s[at + LAST] = sample
        s[at + TIME] = read
        return np.int64(-1)
    if n == np.int64(0):
        s[at + REPEATED] += np.int64(1)
        return np.int64(0)
    before = s[at + TIME]
    predicted = before + ((n * s[at + TICK]) >> np.int64(16))
    error = read - predicted
    s[at + LAST] = sample
    s[at + MISSED] += (n >> np.int64(8)) - np.int64(1)
    if error > LOST_LOCK_NS or error < -LOST_LOCK_NS:
        s[at + TIME] = read
        s[at + TICK] = NOMINAL_TICK
        return read - before
    s[at + TIME] = predicted + (error >> np.int64(4))
    s[at + TICK] += error >> np.int64(1)
    return s[at + TIME] - before
