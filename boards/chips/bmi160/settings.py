"""What the configuration registers mean: rates, bandwidths, ranges (fact sheet sections 3 and 4).

Rates are given as periods in ticks of the 25.6 kHz clock: ODR code c samples every 2^(16−c) ticks
(100 / 2^(8−c) Hz). Scale factors are the chip's own statement: counts per g and per deg/s.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

STANDARD_GRAVITY = 9.80665
"""m/s² in one g."""

ACCEL_COUNTS_PER_G = {0x3: 16384, 0x5: 8192, 0x8: 4096, 0xC: 2048}
GYRO_COUNTS_PER_DEGREE = {0: 16.4, 1: 32.8, 2: 65.6, 3: 131.2, 4: 262.4}

_ACCEL_BANDWIDTH_HZ = {
    0x5: 5.06,
    0x6: 10.12,
    0x7: 20.25,
    0x8: 40.5,
    0x9: 80.0,
    0xA: 162.0,
    0xB: 324.0,
    0xC: 684.0,
}
_GYRO_BANDWIDTH_HZ = {
    0x6: 10.7,
    0x7: 20.8,
    0x8: 39.9,
    0x9: 74.6,
    0xA: 136.6,
    0xB: 254.6,
    0xC: 523.9,
    0xD: 890.0,
}

_OVERSAMPLING = {0: 4, 1: 2, 2: 1}
"""Bandwidth code -> what the normal bandwidth is divided by: OSR4, OSR2, normal."""

_INTERNAL_RATE_CODE = 0xC
"""In low-power averaging the accelerometer measures at 1600 Hz."""


@dataclass(frozen=True, slots=True)
class Stream:
    """One sensor's data path: sample period in sensor clock ticks, −3 dB bandwidth."""

    period: int
    bandwidth_hz: float


UNFILTERED_GYRO = Stream(period=8, bandwidth_hz=_GYRO_BANDWIDTH_HZ[0xD])
UNFILTERED_ACCEL = Stream(period=16, bandwidth_hz=_ACCEL_BANDWIDTH_HZ[0xC])
"""Pre-filtered data: what the FIFO takes when its filter bit is 0 (3200 and 1600 Hz)."""


def odr_period(code: int) -> int:
    """Sample period in ticks of ODR code 0x1 … 0xD."""
    return 1 << (16 - code)


def accel_stream(acc_conf: int) -> Stream | None:
    """The data path that ACC_CONF asks for; None when the combination is invalid."""
    code, bwp, averaging = acc_conf & 0x0F, acc_conf >> 4 & 0x07, bool(acc_conf & 0x80)
    if not 0x1 <= code <= 0xC:
        return None
    if averaging:
        if code + bwp > _INTERNAL_RATE_CODE:
            return None  # the samples to average would take longer than the output period
        return Stream(odr_period(code), _ACCEL_BANDWIDTH_HZ[_INTERNAL_RATE_CODE] / (1 << bwp))
    if bwp not in _OVERSAMPLING:
        return None
    normal = _ACCEL_BANDWIDTH_HZ[max(code, 0x5)] / (1 << max(0x5 - code, 0))
    return Stream(odr_period(code), normal / _OVERSAMPLING[bwp])


def gyro_stream(gyr_conf: int) -> Stream | None:
    """The data path that GYR_CONF asks for; None when the combination is invalid."""
    code, bwp = gyr_conf & 0x0F, gyr_conf >> 4 & 0x03
    if code not in _GYRO_BANDWIDTH_HZ or bwp not in _OVERSAMPLING:
        return None
    return Stream(odr_period(code), _GYRO_BANDWIDTH_HZ[code] / _OVERSAMPLING[bwp])


def accel_counts_per_mps2(acc_range: int) -> float:
    """Sensitivity of ACC_RANGE; a code without a range means 2 g."""
    return ACCEL_COUNTS_PER_G.get(acc_range & 0x0F, ACCEL_COUNTS_PER_G[0x3]) / STANDARD_GRAVITY


def gyro_counts_per_radps(gyr_range: int) -> float:
    """Sensitivity of GYR_RANGE; a code without a range means 2000 deg/s."""
    return GYRO_COUNTS_PER_DEGREE.get(gyr_range & 0x07, GYRO_COUNTS_PER_DEGREE[0]) * 180.0 / pi
