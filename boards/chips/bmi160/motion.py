"""Motion detectors on the accelerometer's samples: any-motion, slow/no-motion, high-g, low-g.

Slopes are differences of consecutive samples in counts. Thresholds scale with the range, so in counts they
do not depend on it: one LSB of a slope threshold is 3.9 mg at 2 g (64 counts), of the high-g threshold
7.8 mg at 2 g (128 counts); 0 means half an LSB. Low-g is absolute: 7.8 mg an LSB in every range.
Times are in ticks of the sensor clock: 2.5 ms = 64, 1.28 s = 32768.

- any-motion: asserted when the slope of an enabled axis exceeds the threshold `dur` + 1 times in a row,
  cleared when all stay below it as often. Slow-motion is the same with its own settings.
- no-motion: asserted when no slope exceeded the threshold for the set time, cleared by the first that does.
- high-g: asserted when an enabled axis stays above the threshold with one sign for the delay, cleared when
  all stay below threshold − hysteresis for the delay.
- low-g: asserted when every axis (or, in sum mode, the sum of magnitudes) stays below the threshold for
  the delay, cleared above threshold + hysteresis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from boards.chips.bmi160.interrupts import Source
from boards.chips.bmi160.register_map import INT_LOWHIGH_0, INT_MOTION_0

DELAY_TICKS = 64
"""2.5 ms."""
QUIET_TICKS = 32_768
"""1.28 s."""

Counts = Sequence[int]


def threshold(code: int, unit: int) -> int:
    """Counts of a threshold register; code 0 is half a unit."""
    return code * unit if code else unit // 2


def no_motion_ticks(code: int) -> int:
    """Duration that the 6-bit int_slo_no_mot_dur stands for: 1.28 … 430.08 s in three steps."""
    if code & 0x20:
        return ((code & 0x1F) + 11) * 8 * QUIET_TICKS
    if code & 0x10:
        return ((code & 0x0F) + 5) * 4 * QUIET_TICKS
    return ((code & 0x0F) + 1) * QUIET_TICKS


def axes_over(values: Counts, limit: int, enabled: int) -> int:
    """Bits (x lowest) of the enabled axes whose magnitude exceeds the limit."""
    over = 0
    for axis, value in enumerate(values):
        if enabled >> axis & 1 and abs(value) > limit:
            over |= 1 << axis
    return over


def first_axis_detail(values: Counts, axes: int) -> int:
    """Sign (bit 3) and triggering axes (bits 2 … 0: z, y, x) for INT_STATUS_2 and _3."""
    lowest = next(axis for axis in range(3) if axes >> axis & 1)
    return axes | (0x08 if values[lowest] < 0 else 0)


@dataclass(slots=True)
class _Streak:
    """Consecutive samples over and under a threshold."""

    over: int = 0
    under: int = 0

    def count(self, exceeded: bool) -> None:
        self.over, self.under = (self.over + 1, 0) if exceeded else (0, self.under + 1)


class MotionDetectors:
    """The detectors' state. `registers` are the chip's register values."""

    def __init__(self, registers: Sequence[int]) -> None:
        self._registers = registers
        self.restart()

    def restart(self) -> None:
        """Forget all history (sensor switched on, range or rate changed)."""
        self._last: Counts | None = None
        self._any = _Streak()
        self._slow = _Streak()
        self._quiet_since: int | None = None
        self._high_since: list[tuple[int, int] | None] = [None, None, None]
        self._high_below: int | None = None
        self._low_since: int | None = None

    def any_motion(self, slopes: Counts, active: bool) -> tuple[bool, int]:
        """(condition, detail when it begins)."""
        registers = self._registers
        enabled = Source.ANY_MOTION.enabled(registers)
        over = axes_over(slopes, threshold(registers[INT_MOTION_0 + 1], 64), enabled)
        needed = (registers[INT_MOTION_0] & 0x03) + 1
        self._any.count(bool(over))
        if not active and self._any.over >= needed:
            return True, first_axis_detail(slopes, over)
        return active and self._any.under < needed, 0

    def slow_or_no_motion(self, slopes: Counts, active: bool, tick: int) -> bool:
        """Condition of the slow-motion or no-motion interrupt, whichever is selected."""
        registers = self._registers
        enabled = Source.NO_MOTION.enabled(registers)
        exceeded = bool(axes_over(slopes, threshold(registers[INT_MOTION_0 + 2], 64), enabled))
        duration = registers[INT_MOTION_0] >> 2
        if registers[INT_MOTION_0 + 3] & 0x01:
            if exceeded or self._quiet_since is None:
                self._quiet_since = tick
            return not exceeded and tick - self._quiet_since >= no_motion_ticks(duration)
        self._slow.count(exceeded)
        needed = (duration & 0x03) + 1
        return self._slow.under < needed if active else self._slow.over >= needed

    def high_g(self, values: Counts, active: bool, tick: int) -> tuple[bool, int]:
        """(condition, detail when it begins)."""
        registers = self._registers
        enabled = Source.HIGH_G.enabled(registers)
        limit = threshold(registers[INT_LOWHIGH_0 + 4], 128)
        delay = (registers[INT_LOWHIGH_0 + 3] + 1) * DELAY_TICKS
        lasted = self._high_lasted(values, axes_over(values, limit, enabled), delay, tick)
        if not active:
            self._high_below = None
            return (True, first_axis_detail(values, lasted)) if lasted else (False, 0)
        hysteresis = (registers[INT_LOWHIGH_0 + 2] >> 6) * 2048
        if axes_over(values, max(limit - hysteresis, 0), enabled):
            self._high_below = None
        elif self._high_below is None:
            self._high_below = tick
        return self._high_below is None or tick - self._high_below < delay, 0

    def _high_lasted(self, values: Counts, over: int, delay: int, tick: int) -> int:
        """Axes that have been over the limit with one sign for the delay."""
        lasted = 0
        for axis in range(3):
            sign = 1 if values[axis] > 0 else -1
            begun = self._high_since[axis]
            if not over >> axis & 1:
                self._high_since[axis] = None
            elif begun is None or begun[1] != sign:
                self._high_since[axis] = (tick, sign)
            elif tick - begun[0] >= delay:
                lasted |= 1 << axis
        return lasted

    def low_g(self, values: Counts, active: bool, tick: int, counts_per_g: int) -> bool:
        """Condition of free fall."""
        registers = self._registers
        limit = threshold(registers[INT_LOWHIGH_0 + 1], 128) * counts_per_g // 16384
        hysteresis = (registers[INT_LOWHIGH_0 + 2] & 0x03) * counts_per_g // 8
        delay = (registers[INT_LOWHIGH_0] + 1) * DELAY_TICKS
        magnitudes = [abs(value) for value in values]
        level = sum(magnitudes) if registers[INT_LOWHIGH_0 + 2] & 0x04 else max(magnitudes)
        if level >= limit + (hysteresis if active or self._low_since is not None else 0):
            self._low_since = None
            return False
        if self._low_since is None:
            self._low_since = tick
        return active or tick - self._low_since >= delay

    def slopes(self, values: Counts) -> Counts | None:
        """Differences to the sample before; None for the first one."""
        last, self._last = self._last, values
        if last is None:
            return None
        return [new - old for new, old in zip(values, last, strict=True)]
