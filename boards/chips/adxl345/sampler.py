"""From the world to the data registers: samples in blocks, as register images.

The world is asked once per block: at the output samples, or, while something detects events on undecimated
data, at every tick; an output sample is then the mean of the last 32 ticks (fewer at faster rates), which has
the noise bandwidth of its rate.

A block is kept as one byte string with 7 bytes an output sample: a zero (what the bus shows during the
address byte) and the six data registers. Reading is slicing. Blocks of output samples are long, since
whatever runs seldom runs slowly; the first after a set-up or a pause is short, since often another follows.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boards.chips.adxl345.sample_kernels import STRIDE, fill_g, fill_means, fill_words
from boards.chips.adxl345.settings import AVERAGED_TICKS, STANDARD_GRAVITY, TICK_RATE_HZ, WordFormat
from boards.chips.oscillator import Oscillator
from boards.chips.world import ImuWorld

FIRST_BLOCK_TICKS, BLOCK_TICKS, FINE_BLOCK_TICKS = 2_816, 22_528, 1_600
"""0.88, 7.04 and 0.5 s of the chip's own clock: the world lets a chip go back by eight seconds when it is
set up anew."""

_SETTLING_PERIODS = 3
"""Of the output, from the switch until the self-test has deflected: the fourth sample shows it all."""
_LONG_AGO = -(1 << 40)

Triple = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Plan:
    """What is sampled: the output period in ticks, whether every tick is wanted, the noise bandwidths."""

    period: int
    fine: bool
    bandwidth_hz: float

    @property
    def grid(self) -> int:
        """Ticks between two values asked of the world."""
        return 1 if self.fine else self.period

    @property
    def window(self) -> int:
        """Values in the mean of an output sample."""
        return min(self.period, AVERAGED_TICKS) if self.fine else 1


@dataclass(frozen=True, slots=True)
class Response:
    """How the sensor answers: g = force / standard gravity · gain + bias + self-test deflection."""

    gain: Triple = (1.0, 1.0, 1.0)
    bias_g: Triple = (0.0, 0.0, 0.0)
    deflection_g: Triple = (0.0, 0.0, 0.0)


class Sampler:
    """Data registers as a function of the chip's ticks."""

    def __init__(self, world: ImuWorld, response: Response, form: WordFormat) -> None:
        self.world = world
        most = getattr(world, "most_ahead_s", math.inf) * TICK_RATE_HZ
        self._first_block, self._block = (int(min(n, most)) for n in (FIRST_BLOCK_TICKS, BLOCK_TICKS))
        self.clock = Oscillator(1, 0)
        self.plan: Plan | None = None
        """None in standby."""
        self.first_tick = self.end_tick = 0
        """The block holds [first_tick, end_tick); empty before the first is loaded."""
        self.image = b""
        self.times: list[int] = []
        """Instants (ns) of the block's output samples and of the one after them."""
        self.held = bytes(STRIDE)
        """The newest sample before the block."""
        self.g: NDArray[np.float64] = np.empty((0, 3))
        """What the sensor feels at the block's values, in g."""
        self.filtered = self.g
        """The same after decimation; of meaning at output samples."""
        self._values: NDArray[np.float64] = np.empty((0, 7))
        self._history = self.g
        self._response = response
        self._first_output = 0
        """Tick of the image's first sample."""
        self._before = response.deflection_g
        self._switched = _LONG_AGO
        self._form = form

    # -- configuration -----------------------------------------------------------------------------

    def restart(self, tick: int, clock: Oscillator, plan: Plan | None) -> None:
        """A new stretch of sampling on a clock that starts anew, `tick` being the last of the old one."""
        self.held = self.registers(tick)
        self.clock = clock
        self.plan = None
        self._switched = _LONG_AGO
        self.configure(0, plan)

    def configure(self, tick: int, plan: Plan | None) -> None:
        """Another plan from the next value after `tick` on; what was sampled until then stays."""
        self.held = self.registers(tick)
        self.plan = plan
        grid = plan.grid if plan is not None else 1
        self.first_tick = self.end_tick = (tick // grid + 1) * grid
        self._history = self.g = self.filtered = np.empty((0, 3))
        self.image, self.times = b"", []

    def convert(self, tick: int, response: Response, form: WordFormat) -> None:
        """Other offsets, format or deflection from the next value after `tick` on."""
        self.cover(tick)
        if response.deflection_g != self._response.deflection_g:
            self._before, self._switched = self._response.deflection_g, tick
        self._response, self._form = response, form
        if self.plan is not None and self.first_tick < self.end_tick:
            row = max(0, (tick - self.first_tick) // self.plan.grid + 1)
            if row < len(self.g):
                self._convert(row)

    # -- reading -----------------------------------------------------------------------------------

    def cover(self, tick: int) -> None:
        """Have the value of `tick` in the block; every block on the way is worked off if ticks are fine."""
        plan = self.plan
        if plan is None:
            return
        while tick >= self.end_tick:
            start, grid = self.end_tick, plan.grid
            if plan.fine:
                self._load(start, FINE_BLOCK_TICKS)
                continue
            ticks = self._block if self.first_tick < start else self._first_block
            if tick >= start + max(self._first_block, grid):  # nobody looked for a long time: jump
                start, ticks = max(start, tick - tick % grid), self._first_block
            self._load(start, ticks)

    def registers(self, tick: int) -> bytes:
        """A zero and the data registers at a tick, which must not lie before the block."""
        self.cover(tick)
        plan = self.plan
        if plan is None:
            return self.held
        at = self.row_of(tick) * STRIDE
        return self.image[at : at + STRIDE] if at >= 0 and self.image else self.held

    def row_of(self, tick: int) -> int:
        """Of the newest output sample at a tick; -1 or less before the block."""
        assert self.plan is not None
        return tick // self.plan.period - self._first_output // self.plan.period

    def tick_of(self, row: int) -> int:
        """The other way round."""
        assert self.plan is not None
        return self._first_output + row * self.plan.period

    def instant_after(self, tick: int, count: int) -> int:
        """Time (ns) of the count-th output sample after `tick`."""
        assert self.plan is not None
        period = self.plan.period
        coming = (tick // period + count) * period
        row = (coming - self._first_output) // period
        if 0 <= row < len(self.times):
            return self.times[row]
        return self.clock.instant(coming)

    # -- blocks ------------------------------------------------------------------------------------

    def _load(self, first: int, ticks: int) -> None:
        plan = self.plan
        assert plan is not None
        if self.image:
            self.held = self.image[-STRIDE:]
        count = max(1, ticks // plan.grid)
        times = self.clock.grid(first, plan.grid, count)
        self._values = np.ascontiguousarray(self.world.sample(times, plan.bandwidth_hz), np.float64)
        if plan.window > 1:
            self._history = np.concatenate((self._history, self.g))[1 - plan.window :]
        self.first_tick, self.end_tick = first, first + count * plan.grid
        self._first_output = -(-first // plan.period) * plan.period
        self.g = np.empty((count, 3))
        self.filtered = np.empty((count, 3)) if plan.window > 1 else self.g
        self.image = b""
        self._convert(0)
        samples = len(self.image) // STRIDE
        self.times = self.clock.grid(self._first_output, plan.period, samples + 1).tolist()

    def _convert(self, row: int) -> None:
        """Make g and the register image of the block from value `row` on."""
        plan, response, form = self.plan, self._response, self._form
        assert plan is not None
        tick = self.first_tick + row * plan.grid
        gain = np.array(response.gain) / STANDARD_GRAVITY
        answer = np.array((gain, response.bias_g, self._before, response.deflection_g))
        ramp = np.array((tick, plan.grid, self._switched, _SETTLING_PERIODS * plan.period), np.int64)
        fill_g(self._values[row:], answer, ramp, self.g[row:])
        if plan.window > 1:
            past = np.concatenate((self._history, self.g[:row]))[1 - plan.window :]
            fill_means(past, self.g[row:], plan.window, self.filtered[row:])
        output = -(-tick // plan.period) * plan.period
        done = (output - self._first_output) // plan.period
        words = np.empty((max(0, -(-(self.end_tick - output) // plan.period)), STRIDE), np.uint8)
        rows = np.array(((output - self.first_tick) // plan.grid, plan.period // plan.grid), np.int64)
        layout = np.array((form.low, form.high, form.mask, form.shift), np.int64)
        fill_words(self.filtered, rows, form.counts_per_g, layout, words)
        self.image = self.image[: done * STRIDE] + words.tobytes()
