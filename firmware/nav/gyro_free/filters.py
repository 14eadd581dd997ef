"""Configuration of the filters side by side: noise, initial uncertainty, reset mode; and their arrays."""

import math
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware.nav import layout as at
from firmware.nav import tuning as cfg
from firmware.nav.config import NavConfig, new_state
from firmware.nav.gyro_free import beginning
from firmware.nav.gyro_free import layout as gl
from firmware.nav.gyro_free.beginning import begin_filter
from firmware.nav.gyro_free.config import G, GyroFreeConfig, Vector, new_sensor
from firmware.nav.gyro_free.states import X_COMPASS_ERROR
from firmware.numerics.fixed_position import units_of_nanodegrees

DEG = math.pi / 180.0
State = tuple[NDArray[Any], NDArray[np.int64]]


@dataclass(frozen=True, kw_only=True)
class FilterConfig:
    """Noise as 1 σ, SI units and radians; ValueError when wrong. Defaults: the document's chapter 5."""

    reset: str = "fusion_feedback"
    rate_noise: float = 0.02 * DEG
    """Of a sample, white, and of the accelerometers."""
    force_noise: float = 1e-3 * G
    rate_walk: float = 1e-6
    """Of the biases, per √s."""
    force_walk: float = 1e-5
    sample_period: float = 0.005
    compass_noise: Vector = (0.5 * DEG, 0.5 * DEG, 1.0 * DEG)
    """White, of roll, pitch, heading."""
    compass_error: tuple[float, float] = (0.035 * DEG, 0.1 * DEG)
    """Gauss-Markov, of tilt and heading …"""
    compass_time: float = 300.0
    """… and its correlation time."""
    position_noise: tuple[float, float] = (10.0, 10.0)
    """Of GPS, horizontal axes and vertical."""
    velocity_noise: float = 0.1
    sigma_position: float = 1.0
    """Initial."""
    sigma_velocity: float = 0.02
    sigma_tilt: float = 10.0 / 60.0 * DEG
    sigma_yaw: float = 20.0 / 60.0 * DEG
    sigma_rate_bias: float = 0.1 * DEG
    sigma_force_bias: float = 5e-3 * G
    sigma_compass: tuple[float, float] = (0.08 * DEG, 0.1 * DEG)
    gates: Vector = (13.82, 16.27, 30.0)
    """χ² of two measurements and of three, and of the largest difference of a filter from the master."""
    isolate_after: tuple[int, int] = (10, 3)
    """Refused measurements, of compass and GPS; accepted ones count back."""
    recover_after: tuple[int, int] = (30, 5)
    """Accepted in a row."""
    silent_after: tuple[float, float] = (2.0, 5.0)
    """s."""
    reopen_after: tuple[int, int] = (1200, 120)
    """Refused in a row, of compass and GPS: the global state is no longer held against them."""
    compass_repeats: int = 20
    fusion_period: float = 1.0
    """s."""
    rate_limit: float = 2000.0 * DEG
    force_limit: float = 16.0 * G
    sensor: GyroFreeConfig = field(default_factory=GyroFreeConfig)


@dataclass(frozen=True)
class Beginning:
    """What a filter begins with."""

    t_ns: int
    latitude_nanodeg: int
    longitude_nanodeg: int
    height: float
    velocity: Vector
    angles: Vector
    """Yaw, pitch, roll."""


@dataclass(frozen=True, slots=True)
class Federation:
    """The arrays of everything."""

    g: NDArray[Any]
    n: NDArray[np.int64]
    compass: State
    gps: State
    master: State
    central: State

    @property
    def all(self) -> tuple[NDArray[Any], ...]:
        """f1, i1, f2, i2, fm, im as the steps take them."""
        return (*self.compass, *self.gps, *self.master)


def new_federation(config: FilterConfig, dtype: Any = np.float32) -> Federation:
    """Arrays, configured; begin them before the first sample."""
    _check(config)
    g, n = new_sensor(config.sensor, dtype)
    _configure_sharing(g, n, config)
    whole = [new_state(_core(config, compass), dtype) for compass in (True, False, True, True)]
    for place, (f, _) in enumerate(whole):
        _switch_off(f, place != 1)
    return Federation(g, n, *whole)


def begin(federation: Federation, config: FilterConfig, start: Beginning, kernels: Any = None) -> None:
    """All filters begin with one state; its information is shared as the mode has it. `kernels`: another
    variant of `firmware.nav.gyro_free.beginning`."""
    entry = begin_filter if kernels is None else kernels.begin_filter
    mode = gl.RESET_NAMES.index(config.reset)
    shares = {gl.ZERO_RESET: (1e6, 1e6, 1.0), gl.PROPORTIONAL: (3.0, 3.0, 3.0)}.get(mode, (2.0, 2.0, 1.0))
    noise = {gl.ZERO_RESET: (4.0, 4.0, 2.0), gl.PROPORTIONAL: (3.0, 3.0, 3.0)}.get(mode, (2.0, 2.0, 1.0))
    filters = (federation.compass, federation.gps, federation.master)
    for which, (f, i) in enumerate(filters):
        _begin(entry, f, i, config, start, shares[which])
        for place in _SHARED_NOISE:
            f[place] *= noise[which]
        federation.g[gl.NOISE_SHARE + which] = noise[which]
    if mode == gl.ZERO_RESET:
        place = at.D + X_COMPASS_ERROR
        federation.compass[0][place : place + 3] = federation.g[gl.NO_INFORMATION + 5]
    if mode == gl.PROPORTIONAL:
        place = at.D + X_COMPASS_ERROR
        federation.master[0][place : place + 3] = 0.0
    _begin(entry, *federation.central, config, start, 1.0)
    federation.n[gl.LAST : gl.LAST + 2] = start.t_ns
    federation.n[gl.TICK] = start.t_ns
    federation.n[gl.FUSION_DUE] = start.t_ns + federation.n[gl.FUSION_NS] - (federation.n[gl.TICK_NS] >> 1)


def _begin(entry: Any, f: Any, i: Any, config: FilterConfig, start: Beginning, widen: float) -> None:
    c = config
    s = np.zeros(beginning.SIZE, f.dtype)
    s[beginning.HEIGHT] = start.height
    s[beginning.VELOCITY : beginning.VELOCITY + 3] = start.velocity
    s[beginning.ANGLES : beginning.ANGLES + 3] = start.angles
    sigmas = (c.sigma_position, c.sigma_velocity, c.sigma_tilt, c.sigma_yaw, c.sigma_rate_bias)
    common = np.array([*sigmas, c.sigma_force_bias]) ** 2 * widen
    s[beginning.VARIANCES : beginning.VARIANCES + 6] = common
    s[beginning.VARIANCES + 6 : beginning.VARIANCES + 8] = np.square(c.sigma_compass)
    latitude = units_of_nanodegrees(start.latitude_nanodeg)
    longitude = units_of_nanodegrees(start.longitude_nanodeg)
    entry(f, i, start.t_ns, latitude, longitude, s)


_SHARED_NOISE = (
    cfg.ANGLE_WALK_VARIANCE, cfg.VELOCITY_WALK_VARIANCE, cfg.POSITION_WALK_VARIANCE,
    cfg.GYRO_BIAS_WALK_VARIANCE, cfg.ACCEL_BIAS_WALK_VARIANCE,
)  # fmt: skip


def _core(c: FilterConfig, compass: bool) -> NavConfig:
    tilt, heading = c.compass_error
    return NavConfig(
        sample_period=c.sample_period,
        covariance_period=0.2,
        angle_random_walk=c.rate_noise * math.sqrt(c.sample_period),
        velocity_random_walk=c.force_noise * math.sqrt(c.sample_period),
        gyro_bias_walk=c.rate_walk,
        accel_bias_walk=c.force_walk,
        accel_bias_sigma=c.sigma_force_bias,
        gyro_instability_sigma=0.0,
        gyro_bias_per_kelvin=0.0,
        position_walk=0.0,
        misalignment_sigma=0.0,
        scale_sigma=0.0,
        manoeuvre_noise=0.0,
        rate_limit=c.rate_limit,
        accel_limit=c.force_limit,
        position_noise=c.position_noise[0],
        position_error_sigma=tilt,
        position_error_time=c.compass_time,
        vertical_factor=heading / tilt,
        velocity_noise=c.velocity_noise,
        latency_sigma=0.0,
        attitude_lost_after=1e6,
        constraint=False,
        standstill=False,
    )


def _switch_off(f: NDArray[Any], compass: bool) -> None:
    """States that these filters do not have get no noise."""
    f[cfg.MOUNTING_VARIANCE] = 0.0
    if not compass:
        f[cfg.POSITION_ERROR_VARIANCE_H] = 0.0
        f[cfg.POSITION_ERROR_VARIANCE_V] = 0.0


def _configure_sharing(g: NDArray[Any], n: NDArray[np.int64], c: FilterConfig) -> None:
    roll, pitch, heading = c.compass_noise
    tilt = 0.5 * (roll**2 + pitch**2)
    places: dict[int, Any] = {
        gl.COMPASS_VARIANCE: (tilt, tilt, heading**2),
        gl.GPS_VARIANCE: (c.position_noise[0] ** 2, c.position_noise[1] ** 2, c.velocity_noise**2),
        gl.GATE_2: c.gates,
        gl.NO_INFORMATION: (1e8, 1e4, 0.25, (10.0 * c.sigma_rate_bias) ** 2, 1.0, 0.01),
        gl.COMPASS_ERROR_VARIANCE: np.square(c.sigma_compass),
        gl.NOISE_SHARE: (1.0, 1.0, 1.0),
    }
    for place, value in places.items():
        g[place : place + np.size(value)] = value
    n[gl.MODE] = gl.RESET_NAMES.index(c.reset)
    n[gl.LIMIT_SCORE : gl.LIMIT_SCORE + 2] = c.isolate_after
    n[gl.LIMIT_GOOD : gl.LIMIT_GOOD + 2] = c.recover_after
    n[gl.LIMIT_SILENCE : gl.LIMIT_SILENCE + 2] = [round(1e9 * t) for t in c.silent_after]
    n[gl.LIMIT_REFUSED : gl.LIMIT_REFUSED + 2] = c.reopen_after
    n[gl.LIMIT_REPEATS] = c.compass_repeats
    n[gl.TICK_NS] = round(1e9 * c.sample_period)
    n[gl.FUSION_NS] = round(1e9 * c.fusion_period)


def _check(config: FilterConfig) -> None:
    if config.reset not in gl.RESET_NAMES:
        raise ValueError(
            f"FilterConfig.reset = {config.reset!r} is not known; one of {', '.join(gl.RESET_NAMES)}"
        )
    for one in fields(config):
        value = getattr(config, one.name)
        values = value if isinstance(value, tuple) else (value,)
        if one.name in ("reset", "sensor"):
            continue
        if not all(0.0 < number < math.inf for number in values):
            raise ValueError(
                f"FilterConfig.{one.name} = {value} must be finite and positive, like the default"
                f" {one.default}"
            )


def adxl345_filters(sensor: GyroFreeConfig, reset: str = "fusion_feedback", **more: Any) -> FilterConfig:
    """Noise of the filters when rate and force come from accelerometers as noisy as `sensor` says: the rate
    walks, by (σ_a / l) √Δt per √s, so much that the master must not run on by itself for a second; nor may it
    refuse GPS for long, since the compass holds tilt and takes a vehicle that accelerates for one that tilts.
    `more`: any other field of FilterConfig."""
    period = more.get("sample_period", 0.005)
    walk = sensor.slow_errors * sensor.acceleration_noise / sensor.arm_length * math.sqrt(period)
    fitting: dict[str, Any] = {
        "rate_noise": 0.1 * DEG,
        "force_noise": sensor.acceleration_noise,
        "rate_walk": walk,
        "force_walk": 1e-4 * G,
        "sigma_rate_bias": 2.0 * DEG,
        "sigma_force_bias": 20e-3 * G,
        "sigma_tilt": 2.0 * DEG,
        "sigma_yaw": 3.0 * DEG,
        "sigma_velocity": 0.5,
        "sigma_position": 10.0,
        "fusion_period": 0.1,
        "velocity_noise": 0.3,
        "reopen_after": (1200, 5),
    }
    return FilterConfig(reset=reset, sensor=sensor, **(fitting | more))
