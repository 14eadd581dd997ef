"""Configuration of the attitude computer in SI units, and its way into the arrays of the float loops."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware.nav.attitude import flags as fl
from firmware.nav.attitude import layout as at

DEG = math.pi / 180.0
G = 9.80665
UNITS_PER_RADIAN = 2.0**40
Vector = tuple[float, float, float]
ZERO: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, kw_only=True)
class AttitudeConfig:
    """Angles in rad, times in s. ValueError when a value is impossible."""

    latitude: float = 0.0
    longitude: float = 0.0
    height: float = 0.0
    """m above the ellipsoid."""
    period: float = 0.008
    """T of an iteration; a sample comes every T/2."""
    method: str = "rk4"
    """One of flags.METHOD_NAMES."""
    drift_compensation: bool = False

    # --- alignment
    alignment_time: float = 2.0
    magnetometer: bool = True
    """Yaw from the magnetometer; otherwise it is `yaw`."""
    declination: float = 0.0
    """East positive."""
    yaw: float = 0.0
    null_gyros: bool = False
    """Take the mean rate of the alignment for the bias of the gyros."""
    attitude: Vector | None = None
    """Yaw, pitch, roll to begin with at once, without alignment."""
    velocity: Vector = ZERO
    """NED, m/s, with `attitude`."""
    rest_rate: float = 10.0 * DEG
    """The largest rate of a vehicle at rest, bias and noise included."""
    rest_force: float = 2.0
    """How far |f| may be from gravity at rest, m/s²."""

    # --- the sensor
    C_b_s: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    """Mounting, row by row: v_b = C_b_s v_s."""
    gyro_range_dps: int = 300
    gyro_bias: Vector = ZERO
    """rad/s, body axes."""
    accel_bias: Vector = ZERO
    """m/s², sensor axes."""
    least_field: float = 1.0e-5
    most_field: float = 1.5e-4
    """T: a magnetic field between these can be the Earth's."""
    longest_bridge: float = 0.5
    """After so long without a sample attitude is lost."""

    def __post_init__(self) -> None:
        _within("latitude", self.latitude, -math.pi / 2, math.pi / 2, "rad")
        _within("longitude", self.longitude, -math.pi, math.pi, "rad")
        _within("height", self.height, -1.0e4, 1.0e5, "m")
        _within("period", self.period, 5.0e-4, 0.02, "s")
        _within("alignment_time", self.alignment_time, 0.0, 60.0, "s")
        _within("declination", self.declination, -math.pi, math.pi, "rad")
        _within("yaw", self.yaw, -2.0 * math.pi, 2.0 * math.pi, "rad")
        if self.method not in fl.METHOD_NAMES:
            raise ValueError(f"method is {self.method!r}; possible: {', '.join(fl.METHOD_NAMES)}")
        if self.gyro_range_dps not in (75, 150, 300):
            raise ValueError(f"gyro_range_dps is {self.gyro_range_dps!r}; possible: 75, 150, 300")
        for k, speed in enumerate(self.velocity):
            _within(f"velocity[{k}]", speed, -500.0, 500.0, "m/s")
        if self.attitude is not None:
            for name, angle in zip(("yaw", "pitch", "roll"), self.attitude, strict=True):
                _within(f"attitude {name}", angle, -2.0 * math.pi, 2.0 * math.pi, "rad")
        for k in range(3):
            _within(f"gyro_bias[{k}]", self.gyro_bias[k], -1.0, 1.0, "rad/s")
            _within(f"accel_bias[{k}]", self.accel_bias[k], -50.0, 50.0, "m/s²")
        _within("rest_rate", self.rest_rate, 0.0, 15.0, "rad/s")
        _within("rest_force", self.rest_force, 0.0, 500.0, "m/s²")
        _within("least_field", self.least_field, 0.0, self.most_field, "T")
        _within("most_field", self.most_field, 0.0, 9.0e-4, "T")
        _within("longest_bridge", self.longest_bridge, 0.0, 60.0, "s")
        matrix = np.array(self.C_b_s, np.float64)
        if matrix.shape != (9,) or not np.allclose(
            matrix.reshape(3, 3) @ matrix.reshape(3, 3).T, np.eye(3), atol=1e-6
        ):
            raise ValueError(f"C_b_s is {self.C_b_s!r}; wanted: 9 numbers, row by row, of a rotation")

    @property
    def alignment_samples(self) -> int:
        """How many samples the alignment takes, at least 1."""
        return max(1, round(self.alignment_time / (0.5 * self.period)))


def initial_values(config: AttitudeConfig) -> dict[int, tuple[float, ...]]:
    """What stands at which place of `s` at the beginning, in SI units."""
    gyro_scale = 0.05 * DEG * config.gyro_range_dps / 300.0
    yaw = config.yaw % (2.0 * math.pi)
    return {
        at.QUATERNION: quaternion(config.attitude or (yaw, 0.0, 0.0)),
        at.VELOCITY: config.velocity if config.attitude is not None else ZERO,
        at.GYRO_BIAS: config.gyro_bias,
        at.GRAVITY: (G,),
        at.PERIOD: (config.period,),
        at.C_B_S: config.C_b_s,
        at.GYRO_SCALE: (gyro_scale, G / 300.0, 0.5e-7),
        at.ACCEL_BIAS: config.accel_bias,
        at.DECLINATION: (config.declination,),
        at.GIVEN_YAW: (yaw,),
        at.REST_RATE: (config.rest_rate,),
        at.REST_FORCE: (config.rest_force,),
        at.PER_ALIGNMENT: (1.0 / config.alignment_samples,),
        at.LEAST_FIELD: (config.least_field,),
        at.MOST_FIELD: (config.most_field,),
    }


def configure_integers(i: NDArray[np.int64], config: AttitudeConfig) -> None:
    """The array `i` at the beginning."""
    i[:] = 0
    running = config.attitude is not None
    i[at.MODE] = fl.RUNNING if running else fl.ALIGNING
    i[at.METHOD] = fl.METHOD_NAMES.index(config.method)
    i[at.LATITUDE] = round(config.latitude * UNITS_PER_RADIAN)
    i[at.LONGITUDE] = round(config.longitude * UNITS_PER_RADIAN)
    i[at.HEIGHT] = round(config.height * 2.0**20)
    i[at.ALIGNMENT_SAMPLES] = config.alignment_samples
    i[at.USE_FIELD] = config.magnetometer
    i[at.NULL_GYROS] = config.null_gyros
    i[at.DRIFT_COMPENSATION] = config.drift_compensation
    i[at.GYRO_LIMIT] = 6000
    i[at.LONGEST_BRIDGE] = round(config.longest_bridge / (0.5 * config.period))


def configure(s: NDArray[Any], i: NDArray[np.int64], config: AttitudeConfig) -> None:
    """Set the arrays of a float loop; `s` may be float32 or float64."""
    configure_integers(i, config)
    s[:] = 0
    for place, values in initial_values(config).items():
        s[place : place + len(values)] = values


def quaternion(angles: Vector) -> tuple[float, float, float, float]:
    """q_nb of yaw, pitch, roll."""
    (cy, cp, cr), (sy, sp, sr) = (tuple(f(0.5 * angle) for angle in angles) for f in (math.cos, math.sin))
    return (
        cy * cp * cr + sy * sp * sr,
        cy * cp * sr - sy * sp * cr,
        cy * sp * cr + sy * cp * sr,
        sy * cp * cr - cy * sp * sr,
    )


def _within(name: str, value: float, low: float, high: float, unit: str) -> None:
    if not low <= value <= high:
        raise ValueError(f"{name} is {value!r}; possible: {low:g} {unit} to {high:g} {unit}")
