"""Configuration of the gyro-free sensor and its way into the arrays."""

import math
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware.nav.gyro_free import layout as at

G = 9.80665
IDENTITY = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
Vector = tuple[float, float, float]
ZERO: Vector = (0.0, 0.0, 0.0)
NONE_OF_NINE = (0.0,) * 9


@dataclass(frozen=True, kw_only=True)
class GyroFreeConfig:
    """SI units and radians; ValueError from `configure` when wrong."""

    arm_length: float = 0.25
    method: str = "fused"
    acceleration_noise: float = 4.6e-3 * G
    """White, 1 σ of a sample of each accelerometer, quantisation included, m/s²."""
    slow_errors: float = 2.0
    """The filter of the rate takes ω̇ for so many times as noisy as white noise makes it: biases
    that drift, and clocks of the chips that run apart."""
    word: float = 0.5e-3 * G
    """m/s² of one count of an accelerometer in the packet."""
    scales: tuple[float, ...] = (1.0,) * 9
    """Factors on what A1 … A9 read …"""
    offsets: tuple[float, ...] = NONE_OF_NINE
    """… and what is taken off then, m/s²."""
    rate_matrix: tuple[float, ...] = IDENTITY
    """ω = matrix · rate − bias, row by row; the same for the specific force."""
    rate_bias: Vector = ZERO
    force_matrix: tuple[float, ...] = IDENTITY
    force_bias: Vector = ZERO
    compass_deviation: tuple[float, ...] = (0.0,) * 5
    """A … E of the deviation, rad."""
    declination: float = 0.0
    initial_rate: Vector = ZERO
    initial_rate_sigma: float = 0.02


def configure(g: NDArray[Any], n: NDArray[np.int64], config: GyroFreeConfig) -> None:
    """Bring `g` and `n` to the state before the first sample."""
    _check(config)
    c = config
    g[:] = 0.0
    n[:] = 0
    noise = c.acceleration_noise / c.arm_length
    places: dict[int, Any] = {
        at.PER_TWO_ARMS: 0.5 / c.arm_length,
        at.RATE_NOISE_VARIANCE: noise**2,
        at.INCREMENT_VARIANCE: (c.slow_errors * noise) ** 2,
        at.LEAST_PRODUCT: 3.0 * noise,
        at.LEAST_CHANGE: 3.0 * math.sqrt(2.0) * noise,
        at.SCALE: [c.word * scale for scale in c.scales],
        at.OFFSET: c.offsets,
        at.RATE_MATRIX: c.rate_matrix,
        at.RATE_BIAS: c.rate_bias,
        at.FORCE_MATRIX: c.force_matrix,
        at.FORCE_BIAS: c.force_bias,
        at.COMPASS_DEVIATION: c.compass_deviation,
        at.DECLINATION: c.declination,
        at.INTEGRAL: c.initial_rate,
        at.METHOD_RATE: c.initial_rate,
        at.FUSED: c.initial_rate,
        at.FUSED_COVARIANCE: np.ravel(np.eye(3) * c.initial_rate_sigma**2),
    }
    for place, value in places.items():
        g[place : place + np.size(value)] = value
    n[at.METHOD] = at.METHOD_NAMES.index(c.method)


def new_sensor(config: GyroFreeConfig, dtype: Any = np.float32) -> tuple[NDArray[Any], NDArray[np.int64]]:
    """Both arrays, configured."""
    g = np.zeros(at.G_SIZE, dtype)
    n = np.zeros(at.N_SIZE, np.int64)
    configure(g, n, config)
    return g, n


_LENGTHS = {
    "scales": 9, "offsets": 9, "rate_matrix": 9, "force_matrix": 9, "compass_deviation": 5,
    "rate_bias": 3, "force_bias": 3, "initial_rate": 3,
}  # fmt: skip
_POSITIVE = ("arm_length", "acceleration_noise", "slow_errors", "word", "initial_rate_sigma")


def _check(config: GyroFreeConfig) -> None:
    for field in fields(config):
        value = getattr(config, field.name)
        if field.name in _LENGTHS:
            if len(value) != _LENGTHS[field.name] or not all(math.isfinite(x) for x in value):
                raise ValueError(
                    f"GyroFreeConfig.{field.name} = {value} must hold {_LENGTHS[field.name]} finite numbers"
                )
        elif field.name in _POSITIVE and not 0.0 < value < math.inf:
            raise ValueError(
                f"GyroFreeConfig.{field.name} = {value} must be finite and positive, "
                f"like the default {field.default}"
            )
    if config.method not in at.METHOD_NAMES:
        raise ValueError(
            f"GyroFreeConfig.method = {config.method!r} is not known; one of {', '.join(at.METHOD_NAMES)}"
        )
    if not math.isfinite(config.declination):
        raise ValueError(
            f"GyroFreeConfig.declination = {config.declination} must be finite, for example 0.05"
        )
