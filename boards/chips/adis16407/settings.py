"""What the settings of MSC_CTRL, SMPL_PRD, SENS_AVG and the calibration registers mean (sections 3 to 5)."""

from __future__ import annotations

from dataclasses import dataclass

from boards.chips.adis16407 import register_map as reg

START_UP_NS = 210_000_000
WAKE_UP_NS = 4_000_000

CLOCK_HZ = 8192
"""Of the counter behind the sample clock: 5 ticks of it are the time base of 0.61035 ms."""
TIME_BASE_TICKS = 5
SLOW_BASE_TICKS = 155
"""18.921 ms: 31 times the other."""

GYRO_RANGES_DPS = {0b100: 300.0, 0b010: 150.0, 0b001: 75.0}
NOISE_BANDWIDTH_HZ = 330.0

SELF_TEST_DPS, SELF_TEST_G = 50.0, 1.0 / 3.0
"""Deflection under manual self-test; a choice, the sheet has no figure."""


@dataclass(frozen=True, slots=True)
class AlarmSetting:
    """One alarm: which output, against what."""

    flag: int
    """In DIAG_STAT."""
    column: int
    """Of the outputs in burst order; −1: off."""
    above: bool
    threshold: int
    samples: int
    """Over which the change is looked at; 0: the value itself."""
    filtered: bool


@dataclass(frozen=True, slots=True)
class Conversion:
    """From what the sensors feel to counts."""

    gyro_range_dps: float = 300.0
    taps: int = 4
    """Of each of the two stages of the filter."""
    gyro_offset_dps: tuple[float, ...] = (0.0, 0.0, 0.0)
    accel_offset: tuple[int, ...] = (0, 0, 0)
    hard_iron: tuple[int, ...] = (0, 0, 0)
    soft_iron: tuple[float, ...] = (1.0, 1.0, 1.0)
    deflection: int = 0
    """Manual self-test: 1 positive, −1 negative."""
    alarms: tuple[AlarmSetting, ...] = ()
    compensated: bool = False
    """Gyros: without the effect of force."""
    aligned: bool = False
    """Accelerometers: as if all three sat at the part's origin."""


def signed(value: int, bits: int) -> int:
    """Two's complement of the lowest bits."""
    value &= (1 << bits) - 1
    return value - (1 << bits) if value >> (bits - 1) else value


def word(values: bytes | bytearray, address: int) -> int:
    """A register out of the file."""
    return values[address] | values[address + 1] << 8


def sample_ticks(values: bytes | bytearray) -> int:
    """Ticks of CLOCK_HZ between samples; 0: the external clock."""
    code = values[reg.SMPL_PRD]
    if code == 0:
        return 0
    base = SLOW_BASE_TICKS if code & 0x80 else TIME_BASE_TICKS
    return base * ((code & 0x7F) + 1)


def is_slow(values: bytes | bytearray) -> bool:
    """Whether the SPI limits of the slow mode hold."""
    return values[reg.SMPL_PRD] >= 10


def conversion(values: bytes | bytearray) -> Conversion:
    """Everything that the outputs depend on."""
    averaging = word(values, reg.SENS_AVG)
    control = word(values, reg.MSC_CTRL)
    axes = range(3)
    return Conversion(
        gyro_range_dps=GYRO_RANGES_DPS.get(averaging >> 8 & 7, 300.0),
        taps=1 << (averaging & 7),
        gyro_offset_dps=tuple(0.0125 * signed(word(values, reg.GYRO_OFF + 2 * k), 13) for k in axes),
        accel_offset=tuple(signed(word(values, reg.ACCL_OFF + 2 * k), 12) for k in axes),
        hard_iron=tuple(signed(word(values, reg.MAGN_HIC + 2 * k), 14) for k in axes),
        soft_iron=tuple((word(values, reg.MAGN_SIC + 2 * k) & 0xFFF) / 2048.0 for k in axes),
        deflection=(control >> 8 & 1) - (control >> 9 & 1),
        compensated=bool(control & 0x80),
        aligned=bool(control & 0x40),
        alarms=tuple(alarm for alarm in (_alarm(values, 0), _alarm(values, 1)) if alarm.column >= 0),
    )


ALARM_COLUMNS = {1: 0, **{k: k - 1 for k in range(2, 11)}, 11: 10, 12: 12, 13: 13}
"""From the code of a source to the output in burst order."""
ALARM_BITS = {0: 12, 10: 14, 12: -12, 13: 12}
"""Width of the threshold by column, negative for two's complement; the others are −14."""


def _alarm(values: bytes | bytearray, which: int) -> AlarmSetting:
    control = word(values, reg.ALM_CTRL)
    magnitude = word(values, reg.ALM_MAG1 + 2 * which)
    column = ALARM_COLUMNS.get(control >> (8 + 4 * which) & 0xF, -1)
    bits = ALARM_BITS.get(column, -14)
    changing = bool(control >> (6 + which) & 1)
    # A change may be negative, whatever the output's own format.
    threshold = signed(magnitude, abs(bits)) if bits < 0 or changing else magnitude & ((1 << bits) - 1)
    return AlarmSetting(
        flag=1 << (8 + which),
        column=column,
        above=bool(magnitude >> 15),
        threshold=threshold,
        samples=max(1, values[reg.ALM_SMPL1 + 2 * which]) if changing else 0,
        filtered=bool(control & 0x10),
    )
