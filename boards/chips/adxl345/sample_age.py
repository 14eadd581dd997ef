"""When the sample was taken that was read last: what a measurement of the age of data asks of the model.

It takes no part in what the chip does, and nothing is kept for it: instants follow from the counts that the
FIFO has.
"""

from __future__ import annotations

from boards.chips.adxl345.chip import Adxl345
from boards.chips.adxl345.fifo import BYPASS


def read_sample_ns(chip: Adxl345) -> int | None:
    """Virtual time (ns) of the sample that the last read of the FIFO took out; None: there is none, or the
    chip is in bypass mode, where reading takes nothing out."""
    core, lane = chip._core, chip._lane
    if not chip.powered or core.fifo.mode == BYPASS or core.sampler.plan is None:
        return None
    if lane._to_ns:
        times, row = lane._times, lane._read - 1
        return times[row] if row >= 0 else 2 * times[0] - times[1]
    period = core.sampler.plan.period
    output = core.tick // period - len(core.fifo.waiting())
    return core.sampler.clock.instant(output * period) if output > 0 else None
