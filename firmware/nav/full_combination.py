"""Full combination of position, velocity and attitude: which states and what tuning a tactical inertial unit
with a two-antenna receiver takes from the one error-state core.

A state that is not chosen has neither variance nor noise and stays exactly zero. Chosen are δr, δv, φ, the
gyros' constant bias and correlated drift and the accelerometers' bias, the document's 18, and unless
`states` says "document" the receiver's correlated position error, 21 (docs/navigation-states.md tells what
the three are worth).
"""

import math
from typing import Any

from firmware.nav.config import DEG, G, NavConfig
from firmware.nav.reference_config import AttitudeReference

HOUR = 3600.0

NOT_CHOSEN: dict[str, Any] = {
    "misalignment_sigma": 0.0,
    "scale_sigma": 0.0,
    "gyro_bias_per_kelvin": 0.0,
    "latency_sigma": 0.0,
    "mounting_sigma": 0.0,
    "constraint": False,
}
"""Responses, temperature coefficients, latency (the time pulse dates epochs) and the vehicle's axes."""

TACTICAL_UNIT: dict[str, Any] = {
    "sample_period": 0.005,
    "angle_random_walk": 0.01 * DEG / math.sqrt(HOUR),
    "velocity_random_walk": 0.01 / math.sqrt(HOUR),
    "gyro_bias_sigma": 0.1 * DEG / HOUR,
    "rest_gyro_sigma": 0.01 * DEG / HOUR,
    "gyro_bias_walk": 2.0e-5 * DEG / HOUR,
    "gyro_instability_sigma": 0.01 * DEG / HOUR,
    "gyro_instability_time": 300.0,
    "accel_bias_sigma": 100e-6 * G,
    "accel_bias_walk": 1.0e-8 * G,
    "manoeuvre_noise": 1.0e-4,
    "earth_rate_errors": True,
    "zero_rate_noise": 5.0e-6,
    "zero_velocity_noise": 0.01,
    "motion_tilt_sigma": 2.0 * DEG,
}
"""Bias 0.1 °/h, 0.01 °/√h; 100 µg, 0.01 m/s/√h."""

TWO_ANTENNA_RECEIVER: dict[str, Any] = {
    "position_noise": 1.5,
    "position_error_sigma": 1.5,
    "position_error_time": 300.0,
    "vertical_factor": 1.0,
    "velocity_noise": 0.1,
    "still_speed": 0.5,
    "position_walk": 0.0,
    "course_noise": 1.0 * DEG,
    "time_tag_noise": 1.0e-4,
    "rejoin_after": 30.0,
    "rejoin_after_outage": 10.0,
    "widen_attitude": 0.5 * DEG,
}
"""1.5 m white and 1.5 m with 300 s an axis, 0.1 m/s; the course also stands for the vehicle's own yaw."""


DOCUMENT_STATES: dict[str, Any] = {
    "position_error_states": False,
    "position_walk": 0.2,
    "standstill": False,
}
"""18 states and the three groups of measurements of the document, nothing else. The walk lets the position
follow the receiver's slow error in minutes: what is no state can neither be estimated nor averaged away."""

STATE_CHOICES: dict[str, dict[str, Any]] = {"receiver": {}, "document": DOCUMENT_STATES}


def full_combination(
    baseline: tuple[float, float, float], states: str = "receiver", **choices: Any
) -> NavConfig:
    """Configuration of a board whose second antenna is `baseline` (body axes, m) from the main one.

    `states`: "receiver", 21 of them and updates at rest, or "document", 18. `choices`: any field of
    NavConfig, instead of what stands here. ValueError for other `states`.
    """
    if states not in STATE_CHOICES:
        raise ValueError(f"states is {states!r}; possible: {', '.join(STATE_CHOICES)}")
    fields = NOT_CHOSEN | TACTICAL_UNIT | TWO_ANTENNA_RECEIVER | STATE_CHOICES[states]
    return NavConfig(**({"attitude": AttitudeReference(baseline=baseline)} | fields | choices))
