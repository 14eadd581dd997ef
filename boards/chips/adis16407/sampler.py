"""From the world to the output registers: samples in blocks, as images of a burst.

The world is asked ahead at the sample instants of the chip's own clock, or one by one at the edges of an
external one. Gyros, accelerometers and magnetometers then go through two boxcar means of 2^N samples (a
Bartlett window):

    y[n] = 2^(−2N) Σ_i Σ_j x[n − i − j],    i, j = 0 … 2^N − 1

Counts are rounded, clipped and packed into 28 bytes a sample: the data bits of SUPPLY_OUT to AUX_ADC, high
byte first, with ND set, as they come in a burst.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from typing import Final

import numpy as np
from numpy.typing import NDArray

from boards.chips.adis16407.block_kernels import (
    BARO,
    OUTPUTS,
    count_block,
    filter_block,
    image_block,
    range_block,
)
from boards.chips.adis16407.elements import Elements
from boards.chips.adis16407.settings import (
    CLOCK_HZ,
    NOISE_BANDWIDTH_HZ,
    SELF_TEST_DPS,
    SELF_TEST_G,
    AlarmSetting,
    Conversion,
)
from boards.chips.oscillator import Oscillator
from boards.chips.world import TenDofWorld

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

STRIDE: Final = 28
FAR: Final = 1 << 62
FIRST_BLOCK, BLOCK, LONGEST_NS = 64, 2048, 4_000_000_000
NEAR: Final = 8
"""So many samples from the newest one on the next one that is read is looked for first."""
MEMORY = 2 * 127 + 255
"""Samples before a block that its filter and alarms may look back at."""

OVER_RANGE, SUPPLY_HIGH, SUPPLY_LOW = 1 << 4, 1 << 1, 1 << 0
SUPPLY_LIMITS_V = (4.75, 5.25)
STANDARD_GRAVITY = 9.80665
ACCEL_RANGE, MAGN_RANGE_T, BARO_RANGE_PA = 18.0 * STANDARD_GRAVITY, 2.5e-4, (1_000.0, 120_000.0)
DPS_AT_300, G_PER_COUNT, TESLA_PER_COUNT = 0.05, 1.0 / 300.0, 0.5e-7
PASCAL_PER_COUNT, KELVIN_PER_COUNT = 0.03125, 0.136
SUPPLY_V_PER_COUNT, ADC_V_PER_COUNT = 2.418e-3, 0.806e-3
FORCE, RATE, TEMPERATURE, FIELD, PRESSURE = slice(0, 3), slice(3, 6), 6, slice(7, 10), 10
"""Columns of the world."""

_BITS_SIGNED = (
    (12, False), *((14, True),) * 9, (14, False), (8, False), (12, True), (12, False),
)  # fmt: skip
_LOW = np.array([-(1 << (b - 1)) if s else 0 for b, s in _BITS_SIGNED], np.int64)
_HIGH = np.array([(1 << (b - s)) - 1 for b, s in _BITS_SIGNED], np.int64)
_MASK = np.array([(1 << b) - 1 for b, _ in _BITS_SIGNED], np.int64)
NEW_DATA = 0x8000


class Sampler:
    """The newest sample as a function of time, which only rises."""

    def __init__(self, world: TenDofWorld, error_ppb: int) -> None:
        self.world = world
        self._error_ppb = error_ppb
        self.elements = Elements()
        self.supply_v = 5.0
        self.adc_v = 0.0
        self.conversion = Conversion()
        self.times: list[int] = []
        self.image = b""
        self.row = -1
        """The newest sample in the block; −1: it lies before."""
        self.held = bytes(STRIDE)
        self.next_ns = FAR
        """When the next sample comes."""
        self.quiet = True
        """No sample of the block raises a flag, and nobody sums."""
        self.smooth_until_ns = 0
        """Before that it is quiet, and NEAR further samples stand in the block; 0: it is not so."""
        self.summing = False
        self.total, self.count = np.zeros(3), 0
        """Gyro outputs (°/s) summed up."""
        self._clock: Oscillator | None = None
        self.halted = False
        """A defect: the sample clock stands still."""
        self._period = 0
        self._tick = 0
        self._raw: Floats = np.empty((0, 11))
        self._before = 0
        """Rows of `_raw` that lie before the block."""
        self._flags: Integers = np.empty(0, np.int64)
        self._filtered: Floats = np.empty((0, 11))
        self._rate_offset: Floats = np.zeros(3)
        """°/s that calibration and self-test add to the gyros' outputs in the block."""
        self._converted = 0
        """The first row that `_filtered` and `_rate_offset` speak of; the one before shows `_held_rates`."""
        self._held_rates = [0.0, 0.0, 0.0]

    # -- control -----------------------------------------------------------------------------------

    def start(self, first_ns: int, period_ticks: int) -> None:
        """Sample from `first_ns` on. `period_ticks` 0: at `external` only."""
        self._settle()
        self._period = period_ticks
        self._tick = 0
        self._clock = Oscillator(CLOCK_HZ, first_ns, self._error_ppb) if period_ticks else None
        self.next_ns = first_ns if period_ticks and not self.halted else FAR

    def period_ns(self, period_ticks: int) -> int:
        """Of the chip's own clock."""
        return Oscillator(CLOCK_HZ, 0, self._error_ppb).instant(period_ticks)

    def look_anew(self, error_ppb: int | None) -> None:
        """Ask for the samples to come again, with another error of the sample clock if one is given."""
        if error_ppb is not None:
            self._error_ppb = error_ppb
        if self._clock is not None and not self.halted:
            self.start(self.next_ns, self._period)

    def halt(self, on: bool, time_ns: int) -> None:
        """The sample clock stands still: the newest sample stays. Not `on`: it goes on."""
        self.halted = on
        if self._clock is not None:
            self.start(time_ns + self.period_ns(self._period), self._period)

    def stop(self) -> None:
        """No more samples; the newest still shows."""
        self._settle()
        self._clock, self.next_ns = None, FAR

    def forget(self) -> None:
        """Without supply the memory of the filter is lost."""
        self.stop()
        self._raw, self._before = np.empty((0, 11)), 0
        self.held, self._held_rates = bytes(STRIDE), [0.0, 0.0, 0.0]

    def convert(self, conversion: Conversion) -> None:
        """Other settings from the next sample on."""
        if conversion == self.conversion:
            return
        self.conversion = conversion
        self.refresh()

    def refresh(self) -> None:
        """Make the samples to come anew, after supply or ADC input changed too."""
        if self.times:
            done = self.row + 1
            old, flags, self._held_rates = self.image, self._flags, self.newest_rates()
            self._convert()
            self.image = old[: done * STRIDE] + self.image[done * STRIDE :]
            self._flags[:done] = flags[:done]
            self._converted = done

    def sum_up(self, on: bool) -> None:
        """Begin or end to sum the gyros' outputs."""
        self.summing = on
        if on:
            self.total, self.count = np.zeros(3), 0
        self.quiet = not on and not self._flags.any()
        self._find_smooth()

    # -- reading -----------------------------------------------------------------------------------

    @property
    def words(self) -> bytes:
        """The newest sample as in a burst."""
        return self.image[self.row * STRIDE : (self.row + 1) * STRIDE] if self.row >= 0 else self.held

    def newest_rates(self) -> list[float]:
        """Gyro outputs in °/s."""
        if self.row < self._converted:
            return self._held_rates
        newest: list[float] = self._rates(slice(self.row, self.row + 1))[0].tolist()
        return newest

    def _rates(self, rows: slice) -> Floats:
        return np.degrees(self._filtered[rows, RATE]) + self._rate_offset

    def step(self, time_ns: int) -> bool:
        """Go on to a time within the block, where no sample raises a flag; False: this is another case."""
        times = self.times
        if time_ns < self.smooth_until_ns:
            first = self.row + 1
            row = bisect_right(times, time_ns, first, first + NEAR)
            if times[row] <= time_ns:
                row = bisect_right(times, time_ns, row)
        elif not self.quiet or not times or time_ns >= times[-1] or self._clock is None:
            return False
        else:
            row = bisect_right(times, time_ns, self.row + 1)
        self.row = row - 1
        self.next_ns = times[row]
        return True

    def advance(self, time_ns: int) -> int:
        """Go on to a time; returns the DIAG_STAT flags that the samples on the way raised."""
        flags = 0
        while self.next_ns <= time_ns:
            if self.row + 1 >= len(self.times):
                self._load(time_ns)
            to = bisect_right(self.times, time_ns) - 1
            if not self.quiet:
                flags |= int(np.bitwise_or.reduce(self._flags[self.row + 1 : to + 1]))
                if self.summing:
                    self.total += self._rates(slice(self.row + 1, to + 1)).sum(axis=0)
                    self.count += to - self.row
            self._move(to)
        return flags

    def external(self, time_ns: int) -> int:
        """An edge of the external clock: one sample."""
        if self.halted:
            return 0
        self._settle()
        self._take(np.array([time_ns], np.int64))
        self._move(0)
        if self.summing:
            self.total += self._rates(slice(0, 1))[0]
            self.count += 1
        return int(self._flags[0])

    def _move(self, row: int) -> None:
        self.row = row
        if self._clock is None:
            return
        if row + 1 < len(self.times):
            self.next_ns = self.times[row + 1]
        else:
            self.next_ns = self._clock.instant(self._tick)

    # -- blocks ------------------------------------------------------------------------------------

    def _settle(self) -> None:
        """End the block with the newest sample."""
        self._held_rates, self.held = self.newest_rates(), self.words
        taken = self._before + self.row + 1
        self._raw = self._raw[max(0, taken - MEMORY) : taken]
        self._before = len(self._raw)
        self.times, self.image, self.row = [], b"", -1
        self._flags, self._converted = np.empty(0, np.int64), 0
        self.quiet = not self.summing
        self.smooth_until_ns = 0

    def _load(self, wanted_ns: int) -> None:
        """The next block: short at first, long when nobody has looked for long."""
        usual = BLOCK if self.times else FIRST_BLOCK
        period_ns = self._period * 1_000_000_000 // CLOCK_HZ
        longest = max(1, LONGEST_NS // period_ns)
        count = min(max(usual, (wanted_ns - self.next_ns) // period_ns), longest)
        self._settle()
        clock = self._clock
        assert clock is not None
        times = clock.grid(self._tick, self._period, count)
        self._tick += count * self._period
        self._take(times)

    def _take(self, times: Integers) -> None:
        values = np.asarray(self.world.sample(times, NOISE_BANDWIDTH_HZ), np.float64)
        self._raw = np.concatenate((self._raw, values))
        self.times = times.tolist()
        self._convert()

    def _convert(self) -> None:
        """Image, flags and rates of the block from `_raw`."""
        setting = self.conversion
        back = max((alarm.samples for alarm in setting.alarms), default=0)
        start = max(0, self._before - back - 2 * (setting.taps - 1))
        raw = self.elements.feel(self._raw[start:], setting, self._period / CLOCK_HZ)
        before = self._before - start
        filtered = np.empty_like(raw)
        stage = np.empty((len(raw) + setting.taps, raw.shape[1]))
        filter_block(raw, setting.taps, np.empty_like(raw), stage, filtered)
        counts = self._counts(filtered)
        image = np.empty(STRIDE * (len(raw) - before), np.uint8)
        image_block(counts[before:], _LOW, _HIGH, _MASK, NEW_DATA, image)
        self.image = image.tobytes()
        self._filtered, self._rate_offset, self._converted = filtered[before:], self._offset_dps(), 0
        flags = self._range_flags(raw[before:])
        for alarm in setting.alarms:
            source = counts if alarm.filtered else self._counts(raw)
            flags[raised(np.clip(source, _LOW, _HIGH)[:, alarm.column], alarm)[before:]] |= alarm.flag
        self._flags = flags
        self.quiet = not self.summing and not flags.any()
        self._find_smooth()

    def _find_smooth(self) -> None:
        times = self.times
        smooth = self.quiet and self._clock is not None and len(times) > NEAR
        self.smooth_until_ns = times[-1 - NEAR] if smooth else 0

    def _offset_dps(self) -> Floats:
        """°/s that calibration and self-test add to the gyros' outputs by the present settings."""
        setting = self.conversion
        return np.array(setting.gyro_offset_dps) + SELF_TEST_DPS * setting.deflection

    def _counts(self, values: Floats) -> Integers:
        """All outputs as integers before clipping, in burst order."""
        setting = self.conversion
        rate_step = DPS_AT_300 * setting.gyro_range_dps / 300.0
        gain = np.ones(OUTPUTS)
        offset = np.zeros(OUTPUTS)
        offset[0] = self.supply_v / SUPPLY_V_PER_COUNT
        gain[1:4] = math.degrees(1.0) / rate_step
        offset[1:4] = self._offset_dps() / rate_step
        gain[4:7] = 1.0 / (STANDARD_GRAVITY * G_PER_COUNT)
        offset[4:7] = SELF_TEST_G * setting.deflection / G_PER_COUNT + np.array(setting.accel_offset)
        gain[7:10] = np.array(setting.soft_iron) / TESLA_PER_COUNT
        offset[7:10] = setting.hard_iron
        gain[BARO] = 1.0 / PASCAL_PER_COUNT
        gain[12] = 1.0 / KELVIN_PER_COUNT
        offset[12] = -25.0 / KELVIN_PER_COUNT
        offset[13] = self.adc_v / ADC_V_PER_COUNT
        counts = np.empty((len(values), OUTPUTS), np.int64)
        count_block(values, gain, offset, counts)
        return counts

    def _range_flags(self, raw: Floats) -> Integers:
        limit = math.radians(self.conversion.gyro_range_dps)
        high = np.array([ACCEL_RANGE] * 3 + [limit] * 3 + [np.inf] + [MAGN_RANGE_T] * 3 + [BARO_RANGE_PA[1]])
        low = -high
        low[PRESSURE] = BARO_RANGE_PA[0]
        flags = np.empty(len(raw), np.int64)
        range_block(raw, low, high, OVER_RANGE, flags)
        if self.supply_v < SUPPLY_LIMITS_V[0]:
            flags |= SUPPLY_LOW
        if self.supply_v > SUPPLY_LIMITS_V[1]:
            flags |= SUPPLY_HIGH
        return flags


def raised(counts: Integers, alarm: AlarmSetting) -> NDArray[np.bool_]:
    """At which samples an alarm's condition holds; a change is the mean one a sample."""
    n = alarm.samples
    if not n:
        return counts > alarm.threshold if alarm.above else counts < alarm.threshold
    held = np.zeros(len(counts), np.bool_)
    change = counts[n:] - counts[:-n]
    held[n:] = change > n * alarm.threshold if alarm.above else change < n * alarm.threshold
    return held
