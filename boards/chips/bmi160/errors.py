"""Error codes of ERR_REG (fact sheet section 3, Bosch API mapping)."""

from __future__ import annotations

from collections.abc import Sequence

from boards.chips.bmi160.acquisition import Acquisition
from boards.chips.bmi160.fifo_feed import unfiltered
from boards.chips.bmi160.interrupts import Source
from boards.chips.bmi160.power import LOW_POWER
from boards.chips.bmi160.register_map import ACC_CONF, GYR_CONF, INT_DATA_0, INT_DATA_1
from boards.chips.bmi160.settings import accel_stream, gyro_stream

DROPPED_COMMAND = 0x40
"""drop_cmd_err."""

ACCEL_CONF_INVALID = 1
GYRO_CONF_INVALID = 2
LOW_POWER_INTERRUPT_UNFILTERED = 3
HEADERLESS_RATES_DIFFER = 6
LOW_POWER_FIFO_UNFILTERED = 7


def error_code(registers: Sequence[int], data: Acquisition) -> int:
    """The error that the present set-up has; 0 without one. Lower codes go first."""
    if accel_stream(registers[ACC_CONF]) is None:
        return ACCEL_CONF_INVALID
    if gyro_stream(registers[GYR_CONF]) is None:
        return GYRO_CONF_INVALID
    low_power = data.power.accel == LOW_POWER
    if low_power and _unfiltered_interrupts(registers):
        return LOW_POWER_INTERRUPT_UNFILTERED
    if data.feed.mismatched:
        return HEADERLESS_RATES_DIFFER
    if low_power and unfiltered(registers)[1]:
        return LOW_POWER_FIFO_UNFILTERED
    return 0


def _unfiltered_interrupts(registers: Sequence[int]) -> bool:
    motion = any(source.enabled(registers) for source in (Source.ANY_MOTION, Source.NO_MOTION))
    level = any(source.enabled(registers) for source in (Source.HIGH_G, Source.LOW_G))
    return (motion and bool(registers[INT_DATA_1] & 0x80)) or (level and bool(registers[INT_DATA_0] & 0x80))
