"""Which samples go into the FIFO and as what frames (fact sheet section 6).

Filtered data come at the ODR, unfiltered data at 1600 Hz (accelerometer) or 3200 Hz (gyroscope); either is
thinned out by 2^downsampling, at the multiples of the longer period in sensor time. A change of a
sensor's set-up puts an input-config frame in front of the next data frame (header mode).
"""

from __future__ import annotations

from collections.abc import Sequence

from boards.chips.bmi160.fifo import (
    ACCEL_FRAME,
    CAPACITY,
    GYRO_FRAME,
    INPUT_CONFIG,
    INPUT_CONFIG_LENGTH,
    Fifo,
)
from boards.chips.bmi160.interrupts import Source
from boards.chips.bmi160.register_map import FIFO_CONFIG_0, FIFO_CONFIG_1, FIFO_DOWNS
from boards.chips.bmi160.sampler import Plan, Sampler
from boards.chips.bmi160.settings import UNFILTERED_ACCEL, UNFILTERED_GYRO, Stream

ACC_CONF_CHANGED, ACC_RANGE_CHANGED, GYR_CONF_CHANGED, GYR_RANGE_CHANGED = 0x01, 0x02, 0x04, 0x08
"""Bits of the input-config frame's byte."""

WATERMARK_UNIT = 4
"""Bytes in one step of FIFO_CONFIG_0."""

_GYRO_ENABLED, _ACCEL_ENABLED, _HEADER, _TAG_INT1, _TAG_INT2, _TIME = 0x80, 0x40, 0x10, 0x08, 0x04, 0x02


def unfiltered(registers: Sequence[int]) -> tuple[bool, bool]:
    """Whether the FIFO takes the gyroscope's, the accelerometer's data before their filters."""
    enabled, downs = registers[FIFO_CONFIG_1], registers[FIFO_DOWNS]
    return bool(enabled & _GYRO_ENABLED and not downs & 0x08), bool(
        enabled & _ACCEL_ENABLED and not downs & 0x80
    )


class FifoFeed:
    """The path from samples to frames."""

    def __init__(self, registers: Sequence[int], fifo: Fifo) -> None:
        self._registers = registers
        self._fifo = fifo
        self._gyro = 0
        self._accel = 0
        self._plan = Plan()
        self.changed = 0
        """Input-config bits that wait for the next data frame."""

    def configure(self, plan: Plan) -> None:
        """Follow the registers and the streams that run."""
        registers = self._registers
        enabled, downs = registers[FIFO_CONFIG_1], registers[FIFO_DOWNS]
        raw_gyro, raw_accel = unfiltered(registers)
        gyro: Stream | None = UNFILTERED_GYRO if raw_gyro else plan.gyro
        accel: Stream | None = UNFILTERED_ACCEL if raw_accel else plan.accel
        self._gyro = self._accel = 0
        if enabled & _GYRO_ENABLED and plan.gyro and gyro:
            self._gyro = gyro.period << (downs & 0x07)
        if enabled & _ACCEL_ENABLED and plan.accel and accel:
            self._accel = accel.period << (downs >> 4 & 0x07)
        self._plan = plan
        self._fifo.header_mode = bool(enabled & _HEADER)

    @property
    def mismatched(self) -> bool:
        """Headerless with two different rates: no frame can be told from another, so none is stored."""
        return bool(not self._fifo.header_mode and self._gyro and self._accel and self._gyro != self._accel)

    @property
    def step(self) -> int:
        """Ticks between instants at which frames may come; 0 when none come."""
        if self.mismatched:
            return 0
        return min((period for period in (self._gyro, self._accel) if period), default=0)

    @property
    def time_enabled(self) -> bool:
        """Whether a read beyond the last frame gets a sensor time frame."""
        return bool(self._registers[FIFO_CONFIG_1] & _TIME)

    @property
    def tags_enabled(self) -> bool:
        """Whether frames carry the levels of the interrupt inputs."""
        return bool(self._registers[FIFO_CONFIG_1] & (_TAG_INT1 | _TAG_INT2))

    def sample(self, tick: int, sampler: Sampler, inputs: int) -> None:
        """Store what was sampled at `tick`. `inputs`: levels of INT1 (bit 0) and INT2 (bit 1)."""
        gyro = self._gyro and tick % self._gyro == 0
        accel = self._accel and tick % self._accel == 0
        if not (gyro or accel):
            return
        data = b""
        if gyro:
            data += (sampler.unfiltered(tick) if self._plan.unfiltered_gyro else sampler.registers(tick))[:6]
        if accel:
            data += (sampler.unfiltered(tick) if self._plan.unfiltered_accel else sampler.registers(tick))[6:]
        if self._fifo.header_mode:
            if self.changed:
                self._fifo.push(bytes((INPUT_CONFIG, self.changed)))
            header = (GYRO_FRAME if gyro else 0) | (ACCEL_FRAME if accel else 0)
            data = bytes((header | self._tags(inputs),)) + data
        self.changed = 0
        self._fifo.push(data)

    def _tags(self, inputs: int) -> int:
        enabled = self._registers[FIFO_CONFIG_1]
        return inputs & ((0x01 if enabled & _TAG_INT1 else 0) | (0x02 if enabled & _TAG_INT2 else 0))

    @property
    def _watermark(self) -> int:
        return self._registers[FIFO_CONFIG_0] * WATERMARK_UNIT

    @property
    def _frame_length(self) -> int:
        """Of the longest data frame."""
        return 6 * (bool(self._gyro) + bool(self._accel)) + self._fifo.header_mode

    @property
    def watermark_reached(self) -> bool:
        """Whether the fill level is at the watermark or above."""
        level = self._watermark
        return bool(level) and len(self._fifo) >= level

    @property
    def full(self) -> bool:
        """Whether the next frame would push the oldest out."""
        return bool(self._gyro or self._accel) and not self._fifo.fits(self._frame_length)

    def steps_to_interrupt(self) -> int:
        """Steps until an enabled FIFO interrupt can fire at the earliest; 0 when none can."""
        if not self.step:
            return 0
        room = []
        if Source.FIFO_WATERMARK.enabled(self._registers) and self._watermark and not self.watermark_reached:
            room.append(self._watermark - len(self._fifo))
        if Source.FIFO_FULL.enabled(self._registers) and not self.full:
            room.append(CAPACITY + 1 - self._frame_length - len(self._fifo))
        if not room:
            return 0
        coming = min(room) - (INPUT_CONFIG_LENGTH if self.changed else 0)
        return max(1, -(-coming // self._frame_length))
