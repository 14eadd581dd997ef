"""Configuration of navigation: everything a board or a tuner may set, in SI units, and its way into the
arrays.

Defaults are those of a BMI160 and a NEO-M8N in a car. Noise of a sensor that its data sheet gives as a
density n per √Hz (one-sided) enters as a random walk n/√2 per √s.
"""

import math
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware.nav import layout as at
from firmware.nav import reference_layout as ref
from firmware.nav import tuning as cfg
from firmware.nav.reference_config import AttitudeReference, configure_reference

DEG = math.pi / 180.0
G = 9.80665
Vector = tuple[float, float, float]
ZERO: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, kw_only=True)
class NavConfig:
    """All tuning of navigation. Angles in rad, times in s, noise as 1 σ; ValueError from `configure` when
    wrong."""

    # --- the board
    C_b_s: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    """Mounting of the sensor, row by row: v_b = C_b_s v_s."""
    antenna_lever_arm: Vector = ZERO
    """From the IMU to the antenna, body axes, m."""
    constraint_lever_arm: Vector = ZERO
    """From the IMU to the point of the vehicle that does not slip sideways (middle of the rear axle)."""
    known_gyro_bias: Vector = ZERO
    """Of a calibration, sensor axes; taken off each sample."""
    known_accel_bias: Vector = ZERO

    # --- the inertial sensor
    sample_period: float = 0.01
    two_sample: bool = True
    """Instantaneous samples with coning and sculling; False: means over the period, one-sample algorithm."""
    covariance_period: float = 0.2
    angle_random_walk: float = 8.0e-5
    """rad/√s."""
    velocity_random_walk: float = 250e-6 / math.sqrt(2.0) * G
    """m/s/√s."""
    accel_bias_sigma: float = 0.045 * G
    gyro_bias_walk: float = 3.0e-6
    """rad/s/√s."""
    accel_bias_walk: float = 2.0e-4
    """m/s²/√s."""
    gyro_instability_sigma: float = 5.0e-5
    """rad/s (10 °/h) …"""
    gyro_instability_time: float = 25.0
    """… and its correlation time."""
    gyro_bias_sigma: float = 0.0
    """Of the gyros as delivered, rad/s, when they are good enough that it helps; 0: learnt at rest alone."""
    earth_rate_errors: bool = False
    """The Earth's rate couples the attitude errors: counts below 1 °/h (prediction)."""
    gyro_bias_per_kelvin: float = 0.05 * DEG
    """1 σ of the coefficient, rad/s/K; the chip tells its temperature."""
    temperature_step: float = 0.5
    """Two temperatures in a row that differ by more, K, are not believed."""
    position_walk: float = 0.2
    """m/√s: position follows GNSS within position_noise / position_walk, 2.5 s, and does not hold on to where
    it was at first: worse than that on average, but better than the receiver itself on every single drive."""
    misalignment_sigma: float = 0.25 * DEG
    scale_sigma: float = 0.006
    manoeuvre_noise: float = 0.0015
    """Share of the horizontal acceleration that scale and misalignment of the accelerometers make wrong …"""
    manoeuvre_time: float = 8.0
    """… for so long at a time."""
    rate_limit: float = 1990.0 * DEG
    """Readings beyond are saturated."""
    accel_limit: float = 15.9 * G

    # --- the GNSS receiver
    position_noise: float = 0.5
    """White, each horizontal axis, m."""
    position_error_sigma: float = 1.5
    """Correlated (first-order Gauss-Markov), each horizontal axis, m."""
    position_error_time: float = 300.0
    position_error_states: bool = True
    """False: the correlated error is no state of the filter, epochs weigh as little as they tell instead."""
    vertical_factor: float = 1.7
    velocity_noise: float = 0.05
    """Each axis, m/s; also the floor of speed over ground."""
    velocity_lag: float = 0.1
    """Unknown delay of the velocity against the position, s; counts while the latency is estimated."""
    epoch_independence: float = 1.0
    """Epochs closer together than this share their errors."""
    course_noise: float = 0.3 * DEG
    """Floor of the course over ground; the share of the velocity noise comes on top."""
    latency_nominal: float = 0.08
    """What the time tag of an epoch already allows for; only reported."""
    latency_sigma: float = 0.02
    """0 when epochs are tagged by the time pulse: the latency is then not estimated."""
    good_hdop: float = 1.5
    """A larger HDOP scales the noise of a receiver that claims no accuracy."""
    time_tag_noise: float = 0.005
    gates: Vector = (10.83, 13.82, 16.27)
    """χ² thresholds for groups of one, two and three measurements (99.9 %)."""
    rejoin_after: float = 10.0
    """Refused for so long, a measurement is believed …"""
    rejoin_after_outage: float = 3.0
    """… and position after an outage so much sooner."""
    widen_attitude: float = 5.0 * DEG
    """Added to attitude when velocity was refused for so long."""
    time_jump: float = 0.3
    """Time of day and board clock may differ by this from epoch to epoch."""
    epochs_after_time_jump: int = 3
    gnss_lost_after: float = 3.0

    # --- the attitude reference
    attitude: AttitudeReference | None = None
    """Two antennas or a compass, where the board has them."""

    # --- the vehicle
    constraint: bool = True
    """Non-holonomic: no velocity sideways nor through the floor."""
    constraint_period: float = 0.5
    constraint_noise: float = 0.12
    """Slip, sway and the road's camber last for a second or two: what is white at this rate."""
    constraint_turn_noise: float = 0.05
    """m/s per m/s² of centripetal acceleration: the slip of the tyres."""
    constraint_min_speed: float = 0.5
    mounting_sigma: float = 3.0 * DEG
    """Yaw and pitch of the vehicle's axes in body axes."""
    standstill: bool = True
    """Zero velocity and zero rate at rest."""
    window: float = 1.0
    still_rate: float = 0.3 * DEG
    """Largest RMS of the rate (three axes) about its mean over a window at rest."""
    still_force: float = 0.06
    still_speed: float = 0.15
    """Largest low-passed GNSS velocity at rest, m/s."""
    still_acceleration: float = 0.25
    """Largest change of the velocity of the state over a window at rest, per s."""
    rest_speed: float = 1.0
    """Largest velocity of the state that rest may correct."""
    zero_velocity_noise: float = 0.02
    zero_rate_noise: float = 2.0e-4

    # --- alignment
    level_time: float = 10.0
    max_rest_rate: float = 6.0 * DEG
    """A mean rate beyond is a turn, not a bias."""
    max_rest_force_error: float = 1.5
    """Largest difference of the mean specific force at rest from gravity, m/s²."""
    rest_gyro_sigma: float = 0.004 * DEG
    """Of the bias learnt at rest, on top of the noise of the mean."""
    heading_speed: float = 3.0
    """Yaw is taken from the course above this speed."""
    heading_max_rate: float = 0.1
    initial_yaw: float | None = None
    initial_yaw_sigma: float = 3.0 * DEG
    motion_time: float = 3.0
    """Length of the alignment in motion."""
    motion_tilt_sigma: float = 2.5 * DEG
    motion_gyro_sigma: float = 0.8 * DEG
    heading_error_limit: float = 20.0 * DEG
    """Alignment begins anew when the course differs from yaw by more …"""
    heading_error_time: float = 4.0
    """… for so long …"""
    heading_check_speed: float = 5.0
    """… above this speed."""

    # --- health
    gap_periods: float = 2.5
    """A longer interval between two samples is dead time."""
    bridge_limit: float = 0.25
    """Dead time up to this is bridged by the mean of the samples around it, beyond by constant velocity."""
    lost_yaw_rate: float = 0.1
    """Unknown rates and acceleration during dead time."""
    lost_tilt_rate: float = 0.02
    lost_force: float = 1.5
    attitude_lost_after: float = 20.0
    """Dead time after which navigation aligns again."""
    silence: float = 0.2
    """Without a good sample for so long, the state goes on by velocity."""
    stuck_time: float = 0.5
    """Six readings unchanged for so long while moving are no measurement."""
    repeat_rate: float = 0.0
    """rad/s between readings of one unchanged rate: a sensor that carries its rounding on toggles."""
    repeat_force: float = 0.0
    """The same of the force, m/s²."""
    check_period: float = 0.5
    """How often the whole state is looked over, and Earth and gravity refreshed."""
    uncertain_position: float = 100.0
    """Horizontal 1 σ above which the mode is degraded."""


def configure(f: NDArray[Any], i: NDArray[np.int64], config: NavConfig) -> None:
    """Bring `f` and `i` to the state before the first sample. ValueError tells the field, its value and
    why."""
    _check(config)
    f[:] = 0.0
    i[:] = 0
    f[at.QUATERNION] = 1.0
    i[at.EVENT_TIME : at.EVENT_TIME + at.EVENT_KINDS] = at.NEVER
    i[_BEGIN_AT_NEVER] = at.NEVER
    f[at.SCATTER_SHARE] = 1.0
    f[[at.TEMPERATURE, at.BIAS_TEMPERATURE, at.TOLD_TEMPERATURE]] = at.NO_TEMPERATURE
    for place, value in _floats(config).items():
        f[place : place + np.size(value)] = value
    for place, value in _integers(config).items():
        i[place] = value
    if not config.position_error_states:
        i[at.POSITION_TIME] = at.NEVER
    if config.attitude is not None:
        configure_reference(f, i, config.attitude)


def new_state(config: NavConfig, dtype: Any = np.float32) -> tuple[NDArray[Any], NDArray[np.int64]]:
    """Both arrays, configured; `dtype` float64 for the reference variant of the kernels."""
    alone = config.attitude is None
    f = np.zeros(at.F_SIZE if alone else ref.F_END, dtype)
    i = np.zeros(at.I_SIZE if alone else ref.I_END, np.int64)
    configure(f, i, config)
    return f, i


_BEGIN_AT_NEVER = [
    at.TIME, at.FIX_TIME, at.GOOD_TIME, at.EPOCH_VALID, at.LEVELLED_AT, at.START_TIME, at.DEAD_UNTIL,
    at.POSITION_REFUSED_SINCE,
    at.VELOCITY_REFUSED_SINCE, at.HEADING_WRONG_SINCE, at.INNOVATION_TIME,
]  # fmt: skip


def _floats(c: NavConfig) -> dict[int, Any]:
    vertical = c.vertical_factor**2
    return {
        cfg.C_B_S: c.C_b_s,
        cfg.KNOWN_BIAS: c.known_gyro_bias + c.known_accel_bias,
        cfg.ANTENNA: c.antenna_lever_arm,
        cfg.AXLE: c.constraint_lever_arm,
        cfg.PERIOD: c.sample_period,
        # half a sample less, so that rounding does not make it one sample more
        cfg.COVARIANCE_PERIOD: c.covariance_period - 0.5 * c.sample_period,
        cfg.LONGEST_INTERVAL: c.gap_periods * c.sample_period,
        cfg.BRIDGE_LIMIT: c.bridge_limit,
        cfg.ATTITUDE_LOST: c.attitude_lost_after,
        cfg.LOST_YAW_RATE_SQUARE: c.lost_yaw_rate**2,
        cfg.LOST_TILT_RATE_SQUARE: c.lost_tilt_rate**2,
        cfg.LOST_FORCE_SQUARE: c.lost_force**2,
        cfg.RATE_LIMIT: c.rate_limit,
        cfg.ACCEL_LIMIT: c.accel_limit,
        cfg.ANGLE_WALK_VARIANCE: c.angle_random_walk**2,
        cfg.VELOCITY_WALK_VARIANCE: c.velocity_random_walk**2,
        cfg.MANOEUVRE_VARIANCE: c.manoeuvre_noise**2 * c.manoeuvre_time,
        cfg.ACCEL_BIAS_VARIANCE: c.accel_bias_sigma**2,
        cfg.GYRO_BIAS_WALK_VARIANCE: c.gyro_bias_walk**2,
        cfg.ACCEL_BIAS_WALK_VARIANCE: c.accel_bias_walk**2,
        cfg.MISALIGNMENT_VARIANCE: c.misalignment_sigma**2,
        cfg.SCALE_VARIANCE: c.scale_sigma**2,
        cfg.POSITION_VARIANCE: c.position_noise**2,
        cfg.POSITION_ERROR_VARIANCE_H: c.position_error_sigma**2,
        cfg.POSITION_ERROR_VARIANCE_V: c.position_error_sigma**2 * vertical,
        # what has no variance must not decay either: its column of U would grow without bound
        cfg.PER_POSITION_ERROR_TIME: 1.0 / c.position_error_time if _has_receiver_error(c) else 0.0,
        cfg.VERTICAL_FACTOR_SQUARE: vertical,
        cfg.GNSS_VELOCITY_VARIANCE: c.velocity_noise**2,
        cfg.EPOCH_INDEPENDENCE: c.epoch_independence,
        cfg.VELOCITY_LAG_SQUARE: c.velocity_lag**2 if c.latency_sigma > 0.0 else 0.0,
        cfg.COURSE_VARIANCE: c.course_noise**2,
        cfg.TIME_TAG_VARIANCE: c.time_tag_noise**2,
        cfg.LATENCY_NOMINAL: c.latency_nominal,
        cfg.LATENCY_VARIANCE: c.latency_sigma**2,
        cfg.PER_GOOD_HDOP: 1.0 / c.good_hdop,
        cfg.GATE_1: c.gates,
        cfg.WIDEN_ATTITUDE_VARIANCE: c.widen_attitude**2,
        cfg.CONSTRAINT_NOISE: c.constraint_noise,
        cfg.CONSTRAINT_TURN: c.constraint_turn_noise,
        cfg.CONSTRAINT_MIN_SPEED: c.constraint_min_speed,
        cfg.MOUNTING_VARIANCE: c.mounting_sigma**2,
        cfg.WINDOW: c.window - 0.5 * c.sample_period,
        cfg.STILL_RATE_SQUARE: c.still_rate**2,
        cfg.STILL_FORCE_SQUARE: c.still_force**2,
        cfg.STILL_SPEED_SQUARE: c.still_speed**2,
        cfg.STILL_ACCELERATION_SQUARE: (c.still_acceleration * c.window) ** 2,
        cfg.REST_SPEED_SQUARE: c.rest_speed**2,
        cfg.ZERO_VELOCITY_VARIANCE: c.zero_velocity_noise**2,
        cfg.ZERO_RATE_VARIANCE: c.zero_rate_noise**2,
        cfg.MAX_REST_RATE_SQUARE: c.max_rest_rate**2,
        cfg.MAX_REST_FORCE_ERROR: c.max_rest_force_error,
        cfg.STANDARD_GRAVITY: G,
        cfg.REST_GYRO_VARIANCE: c.rest_gyro_sigma**2,
        cfg.HEADING_SPEED: c.heading_speed,
        cfg.HEADING_MAX_RATE: c.heading_max_rate,
        cfg.INITIAL_YAW: c.initial_yaw or 0.0,
        cfg.INITIAL_YAW_VARIANCE: c.initial_yaw_sigma**2,
        cfg.MOTION_TILT_VARIANCE: c.motion_tilt_sigma**2,
        cfg.MOTION_GYRO_VARIANCE: c.motion_gyro_sigma**2,
        cfg.HEADING_CHECK_SPEED: c.heading_check_speed,
        cfg.HEADING_ERROR_LIMIT: c.heading_error_limit,
        cfg.UNCERTAIN_SQUARE: c.uncertain_position**2,
        cfg.REPEAT_RATE: c.repeat_rate,
        cfg.REPEAT_FORCE: c.repeat_force,
        cfg.POSITION_WALK_VARIANCE: c.position_walk**2,
        cfg.GYRO_PER_KELVIN_VARIANCE: c.gyro_bias_per_kelvin**2,
        cfg.TEMPERATURE_STEP: c.temperature_step,
        cfg.GYRO_INSTABILITY_VARIANCE: c.gyro_instability_sigma**2,
        cfg.PER_INSTABILITY_TIME: 1.0 / c.gyro_instability_time if c.gyro_instability_sigma > 0.0 else 0.0,
        cfg.EARTH_ERRORS: float(c.earth_rate_errors),
        cfg.GYRO_VARIANCE: c.gyro_bias_sigma**2,
        cfg.POSITION_ERROR_WEIGHT: 0.0 if c.position_error_states else 2.0 * c.position_error_time,
    }


def _integers(c: NavConfig) -> dict[int, int]:
    return {
        cfg.TWO_SAMPLE: int(c.two_sample),
        cfg.CONSTRAINT_ON: int(c.constraint),
        cfg.STANDSTILL_ON: int(c.standstill),
        cfg.YAW_IS_GIVEN: int(c.initial_yaw is not None),
        cfg.RING_SPACING_NS: _ns(0.95 * max(c.sample_period, 0.01)),
        cfg.PERIOD_NS: _ns(c.sample_period),
        cfg.SILENCE_NS: _ns(max(c.silence, 2.5 * c.sample_period)),
        cfg.GNSS_LOST_NS: _ns(c.gnss_lost_after),
        cfg.REJOIN_AFTER_NS: _ns(c.rejoin_after),
        cfg.REJOIN_AFTER_OUTAGE_NS: _ns(c.rejoin_after_outage),
        cfg.TIME_JUMP_NS: _ns(c.time_jump),
        cfg.EPOCHS_AFTER_JUMP: c.epochs_after_time_jump,
        cfg.HEADING_ERROR_NS: _ns(c.heading_error_time),
        cfg.CONSTRAINT_NS: _ns(c.constraint_period - 0.5 * c.sample_period),
        cfg.LEVEL_WINDOWS: math.ceil(c.level_time / c.window),
        cfg.MOTION_NS: _ns(c.motion_time),
        cfg.CHECK_NS: _ns(c.check_period),
        cfg.WINDOW_NS: _ns(c.window),
        cfg.STUCK_SAMPLES: math.ceil(c.stuck_time / c.sample_period),
        cfg.REFERENCE_ON: int(c.attitude is not None),
    }


def _has_receiver_error(c: NavConfig) -> bool:
    return c.position_error_states and c.position_error_sigma > 0.0


def _ns(seconds: float) -> int:
    return round(seconds * 1e9)


_MAY_BE_ZERO = {
    "latency_sigma", "latency_nominal", "initial_yaw", "gyro_bias_walk", "accel_bias_walk",
    "manoeuvre_noise", "position_walk", "gyro_bias_per_kelvin", "gyro_instability_sigma",
    "misalignment_sigma", "scale_sigma", "course_noise", "velocity_lag", "time_tag_noise",
    "constraint_turn_noise", "repeat_rate", "repeat_force",
    "rest_gyro_sigma", "epochs_after_time_jump", "gyro_bias_sigma", "position_error_sigma", "mounting_sigma",
}  # fmt: skip


def _check(config: NavConfig) -> None:
    for field in fields(config):
        value = getattr(config, field.name)
        if isinstance(value, tuple):
            if not all(math.isfinite(x) for x in value):
                raise ValueError(f"NavConfig.{field.name} = {value} holds a value that is not finite")
        elif isinstance(value, int | float) and not isinstance(value, bool):
            lowest = 0.0 if field.name in _MAY_BE_ZERO else 1e-12
            if not lowest <= value < math.inf and field.name != "initial_yaw":
                raise ValueError(
                    f"NavConfig.{field.name} = {value} must be finite and "
                    f"{'not negative' if not lowest else 'positive'}, "
                    f"like the default {field.default}"
                )
    c = np.reshape(config.C_b_s, (3, 3)) if len(config.C_b_s) == 9 else np.zeros((3, 3))
    if not (np.allclose(c @ c.T, np.eye(3), atol=1e-5) and np.linalg.det(c) > 0):
        raise ValueError(
            f"NavConfig.C_b_s = {config.C_b_s} is no rotation matrix; "
            "a valid one is (1, 0, 0, 0, 1, 0, 0, 0, 1)"
        )
    for name in ("antenna_lever_arm", "constraint_lever_arm", "known_gyro_bias", "known_accel_bias", "gates"):
        if len(getattr(config, name)) != 3:
            raise ValueError(f"NavConfig.{name} = {getattr(config, name)} must have three values")
