"""From the world to the data registers: samples of both sensors in blocks, as register images.

Accelerometer and gyroscope sample on one clock; instants are the multiples of a stream's period in sensor
time (fact sheet section 7). The world is asked once per block on the grid of the fastest stream and with
the widest bandwidth; a slower or narrower stream takes the mean over the 2^k last grid samples, which has k
octaves less noise bandwidth. So with equal settings of both sensors the samples are the world's
instantaneous values.

A block is kept as one byte string with 16 bytes a grid sample: a zero (what the bus shows during the
address byte), then the registers 0x0C … 0x1A after that sample: data and sensor time. Reading is slicing.
Blocks are long because whatever runs seldom runs slowly, out of cold caches: 0.9 s of samples cost 105 µs,
7 s 360 µs. The first after a set-up or a pause is short, since often another one follows.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import log2

import numpy as np
from numpy.typing import NDArray

from boards.chips.bmi160.block_kernels import DATA_END, STRIDE, fill_frames
from boards.chips.bmi160.resampling import hold, running_mean
from boards.chips.bmi160.sensor_clock import SensorClock
from boards.chips.bmi160.settings import UNFILTERED_ACCEL, UNFILTERED_GYRO, Stream
from boards.chips.world import ImuWorld

FIRST_BLOCK_TICKS, BLOCK_TICKS = 22_528, 180_224
"""0.88 and 7.04 s of the chip's own clock: the world lets a chip go back by eight seconds when it is set up
anew."""

_GYR, _ACC = slice(3, 6), slice(0, 3)
"""Columns of the world's array."""


@dataclass(frozen=True, slots=True)
class Plan:
    """Which streams run. A sensor that is not sampling has None and holds its registers."""

    gyro: Stream | None = None
    accel: Stream | None = None
    unfiltered_gyro: bool = False
    """The FIFO wants the gyroscope before its filter."""
    unfiltered_accel: bool = False

    def streams(self) -> list[Stream]:
        """All that must be sampled."""
        streams = [stream for stream in (self.gyro, self.accel) if stream is not None]
        if self.gyro is not None and self.unfiltered_gyro:
            streams.append(UNFILTERED_GYRO)
        if self.accel is not None and self.unfiltered_accel:
            streams.append(UNFILTERED_ACCEL)
        return streams


@dataclass(frozen=True, slots=True, eq=False)
class Conversion:
    """counts = value · scale + bias for the world's columns (specific force, angular rate), each (6,)."""

    scale: NDArray[np.float64]
    bias: NDArray[np.float64]


class Sampler:
    """Data registers as a function of sensor time."""

    def __init__(self, clock: SensorClock, world: ImuWorld, conversion: Conversion) -> None:
        self.clock = clock
        self.world = world
        self.plan = Plan()
        self.grid = 0
        """Ticks between two grid samples; 0 while no sensor samples."""
        self.first_tick = 0
        self.end_tick = 0
        """The block holds the grid samples in [first_tick, end_tick); empty before the first is loaded."""
        self.image = b""
        self.instants: NDArray[np.int64] = np.empty(0, np.int64)
        """When the block's samples come (ns), and the one after them."""
        self.times: list[int] = []
        """The same as integers."""
        self.held = bytes(12)
        """The data registers before the block's first sample."""
        self._resume_tick = 0
        self._conversion = conversion
        self._bandwidth = 0.0
        self._longest = 1
        self._values: NDArray[np.float64] = np.empty((0, 7))
        self._filtered = self._values
        self._history = self._values
        self._raw_image = b""

    # -- configuration -----------------------------------------------------------------------------

    def configure(self, tick: int, plan: Plan) -> None:
        """New streams from the next grid sample after `tick` on; what was sampled until then stays."""
        self.held = self.registers(tick)
        self.plan = plan
        streams = plan.streams()
        self.grid = min((stream.period for stream in streams), default=0)
        self._bandwidth = max((stream.bandwidth_hz for stream in streams), default=0.0)
        self._resume_tick = (tick // self.grid + 1) * self.grid if self.grid else tick + 1
        self.first_tick = self.end_tick = self._resume_tick
        self._history = np.empty((0, 7))
        self._longest = max((self._averaged(stream) for stream in streams), default=1)

    def convert(self, tick: int, conversion: Conversion) -> None:
        """New ranges, offsets or deflection from the next sample after `tick` on."""
        self.cover(tick)
        self._conversion = conversion
        if self.first_tick < self.end_tick and tick < self.end_tick:
            self._quantise(max(0, (tick - self.first_tick) // self.grid + 1))

    # -- reading -----------------------------------------------------------------------------------

    def cover(self, tick: int) -> None:
        """Have the grid sample of `tick` (or the wait for the first one) in the block."""
        if not self.grid or tick < self.end_tick:
            return
        start = self.end_tick
        ticks = BLOCK_TICKS if self.first_tick < start else FIRST_BLOCK_TICKS
        if tick >= start + max(FIRST_BLOCK_TICKS, self.grid):  # nobody looked for a long time: jump
            slowest = max(stream.period for stream in self.plan.streams())
            start = max(start, tick - tick % slowest)
            ticks = FIRST_BLOCK_TICKS
            self._history = np.empty((0, 7))
        self._load(start, ticks)

    def registers(self, tick: int) -> bytes:
        """The data registers 0x0C … 0x17 at a sensor time."""
        self.cover(tick)
        if not self.grid or tick < self.first_tick:
            return self.held
        at = (tick - self.first_tick) // self.grid * STRIDE
        return self.image[at + 1 : at + DATA_END]

    def frames(self, row: int) -> list[bytes]:
        """The block's image from its sample `row` on, cut up."""
        frames: list[bytes] = np.frombuffer(self.image, f"V{STRIDE}")[row:].tolist()
        return frames

    def unfiltered(self, tick: int) -> bytes:
        """Like `registers`, of the data before the filters."""
        at = (tick - self.first_tick) // self.grid * STRIDE
        return self._raw_image[at + 1 : at + DATA_END]

    def physical(self, tick: int) -> NDArray[np.float64]:
        """What the sensors feel at a grid sample in the block: specific force, rate, temperature (7,)."""
        row: NDArray[np.float64] = self._filtered[(tick - self.first_tick) // self.grid]
        return row

    def visit(self, after: int, upto: int, step: int, visitor: Callable[[int], None]) -> None:
        """Call `visitor(tick)` in order for the multiples of `step` in (after, upto] that were sampled."""
        tick = max((after // step + 1) * step, self._resume_tick)
        tick += -tick % step
        while tick <= upto:
            self.cover(tick)
            visitor(tick)
            tick += step

    def last_sample(self, tick: int, stream: Stream | None) -> int:
        """Sensor time of a stream's newest sample at `tick`, −1 before its first under this plan."""
        if stream is None:
            return -1
        sample = tick - tick % stream.period
        return sample if sample >= self._resume_tick else -1

    # -- blocks ------------------------------------------------------------------------------------

    def _load(self, first: int, ticks: int) -> None:
        if self.first_tick < self.end_tick:
            self.held = self.image[1 - STRIDE : DATA_END - STRIDE]
        lead = 0
        if not len(self._history):
            lead = min(self._longest - 1, (first - self._resume_tick) // self.grid)
        count = max(1, ticks // self.grid)
        times = self.clock.grid(first - lead * self.grid, self.grid, lead + count + 1)
        values = np.ascontiguousarray(self.world.sample(times[:-1], self._bandwidth), np.float64)
        if lead:
            self._history, values = values[:lead], values[lead:]
        self.instants = times[lead:]
        self.times = self.instants.tolist()
        self.first_tick = first
        self.end_tick = first + count * self.grid
        self._values = values
        self._filter()
        self._quantise(0)

    def _averaged(self, stream: Stream) -> int:
        """Grid samples in the mean that narrows the grid's bandwidth down to the stream's."""
        return 1 << max(0, round(log2(self._bandwidth / stream.bandwidth_hz)))

    def _filter(self) -> None:
        """Bring both sensors to their own bandwidth; keep the samples that the next block's means need."""
        plan, values = self.plan, self._values
        self._filtered = values
        if self._longest == 1:
            return
        gyro = self._averaged(plan.gyro) if plan.gyro else 1
        accel = self._averaged(plan.accel) if plan.accel else 1
        past = self._history
        self._filtered = values.copy()
        self._filtered[:, _GYR] = running_mean(past[:, _GYR], values[:, _GYR], gyro)
        self._filtered[:, _ACC] = running_mean(past[:, _ACC], values[:, _ACC], accel)
        self._history = np.concatenate((past, values))[-(self._longest - 1) :]

    def _quantise(self, row: int) -> None:
        """Make the block's register image from `row` on."""
        frame = self._frame(self._filtered[row:], row)
        plan, grid = self.plan, self.grid
        end = row * STRIDE
        before = self.image[end - STRIDE + 1 : end - STRIDE + DATA_END] if row else self.held
        gyro, accel = plan.gyro, plan.accel
        if gyro is None or gyro.period != grid or accel is None or accel.period != grid:
            first = self.first_tick + row * grid
            hold(frame[:, 1:7], gyro, first, grid, before[:6])
            hold(frame[:, 7:DATA_END], accel, first, grid, before[6:])
        self.image = self.image[:end] + frame.tobytes()
        if plan.unfiltered_gyro or plan.unfiltered_accel:
            self._raw_image = self._raw_image[:end] + self._frame(self._values[row:], row).tobytes()

    def _frame(self, values: NDArray[np.float64], row: int) -> NDArray[np.uint8]:
        """Counts of (n, 7) values, of which the first is the block's `row`, as (n, 16) bytes."""
        frames = np.empty((len(values), STRIDE), np.uint8)
        scale, bias = self._conversion.scale, self._conversion.bias
        fill_frames(values, scale, bias, self.first_tick + row * self.grid, self.grid, frames)
        return frames
