"""A loosely coupled GNSS/INS filter in double precision, the measure of sensors, not of the firmware.

Closed loop, 15 errors (`host.simulate.loose_prediction`), updated by position and velocity. It knows what
error model the sensor has; that is what makes its drift a property of the sensor.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from host.sim.earth import radii_and_gravity
from host.sim.errors.drawn import DEG, MILLI_G, Specimen, Triad
from host.sim.errors.schema import ImuErrors
from host.sim.mechanization import HEIGHT, LATITUDE, LONGITUDE, QUATERNION, STATE, VELOCITY
from host.sim.schema import PerAxis
from host.simulate.loose_prediction import (
    BIAS_G,
    ERRORS,
    POSITION,
    SIGMA_A,
    SIGMA_G,
    SPEED,
    TILT,
    TIME_A,
    TIME_G,
    TUNING,
    WALK_A,
    WALK_G,
    predict,
)

Floats = NDArray[np.float64]

LASTING_S = 1e7
LEAST = 1e-12
"""Random walks and biases below this are taken for this, so that a perfect sensor leaves P regular."""


@dataclass(frozen=True)
class Known:
    """What the filter knows of a sensor."""

    tuning: Floats
    """As `host.simulate.loose_prediction` lays it out."""
    bias_sigmas: Floats
    """(6,): of the biases at the beginning, gyro and accelerometer."""


def known_of(specimen: Specimen, errors: ImuErrors) -> Known:
    """Random walks n/√2 of the densities, σ and T of the biases; into σ goes what the temperature does.

    A bias that is drawn when the sensor is switched on, or walks, does not go back to nothing: it is carried
    as one that lasts for ever (T = LASTING_S), driven as strongly as the parts that change drive it.
    """
    tuning, first = np.empty(TUNING), np.empty(6)
    rise, warming = abs(errors.temperature.rise_k), errors.temperature.rise_time_s
    gyro, accelerometer = errors.gyro, errors.accelerometer
    triads: tuple[tuple[Triad, tuple[int, int, int], float, PerAxis, PerAxis], ...] = (
        (
            specimen.gyro,
            (WALK_G, SIGMA_G, TIME_G),
            DEG,
            gyro.turn_on_bias_dps,
            gyro.bias_temperature_dps_per_k,
        ),
        (
            specimen.accelerometer,
            (WALK_A, SIGMA_A, TIME_A),
            MILLI_G,
            accelerometer.turn_on_bias_mg,
            accelerometer.bias_temperature_mg_per_k,
        ),
    )
    for k, (triad, (walk, sigma, time), unit, turn_on, per_kelvin) in enumerate(triads):
        tuning[walk : walk + 3] = np.maximum(LEAST, triad.noise_density / math.sqrt(2.0))
        drawn = np.array([max(LEAST, process.sigma) for process in triad.processes[:3]])
        times = np.array([process.correlation_s or 1.0 for process in triad.processes[:3]])
        walks = np.array([process.sigma for process in triad.processes[3:6]])
        constant = unit * np.broadcast_to(np.asarray(turn_on, dtype=np.float64), 3)
        warmed = unit * rise * np.broadcast_to(np.asarray(per_kelvin, dtype=np.float64), 3)
        lasting = (constant > 0.0) | (walks > 0.0)
        drive = 2.0 * drawn**2 / times + walks**2 + 2.0 * warmed**2 / warming
        whole = np.hypot(drawn, warmed)
        tuning[sigma : sigma + 3] = np.where(lasting, np.sqrt(0.5 * drive * LASTING_S), whole)
        tuning[time : time + 3] = np.where(lasting, LASTING_S, times)
        first[3 * k : 3 * k + 3] = np.hypot(whole, constant)
    return Known(tuning, first)


class LooseFilter:
    """One filter, from a roughly known beginning."""

    def __init__(self, known: Known, state: Floats, sigma_tilt: float, sigma_yaw: float) -> None:
        """`state` (10,): position, velocity, q_nb; its 1 σ in rad. Velocity 0.1 m/s, position 0.1 m."""
        self.tuning = known.tuning
        self.state = np.zeros(STATE)
        self.state[: QUATERNION + 4] = state
        self.bias = np.zeros(6)
        sigmas = np.empty(ERRORS)
        sigmas[POSITION:TILT] = 0.1
        sigmas[TILT:BIAS_G] = sigma_tilt, sigma_tilt, sigma_yaw
        sigmas[BIAS_G:] = known.bias_sigmas
        self.covariance = np.diag(sigmas**2)

    def predict(self, increments: Floats, lengths: Floats) -> None:
        """Over increments (n, 6: Δθ rad, Δv m/s) of intervals of `lengths` (n) s."""
        if len(increments):
            predict(self.state, self.bias, self.covariance, increments, lengths, self.tuning)

    def update(self, place: Floats, velocity: Floats, sigma_m: float, sigma_mps: float) -> None:
        """With a receiver's latitude, longitude (rad), height (m), velocity (m/s), of equal σ on all axes."""
        state = self.state
        sin = math.sin(state[LATITUDE])
        m, n, _ = radii_and_gravity(sin, state[HEIGHT])
        scale = np.array([m, n * math.cos(state[LATITUDE]), -1.0])
        off = np.concatenate(((state[: HEIGHT + 1] - place) * scale, state[VELOCITY:QUATERNION] - velocity))
        p = self.covariance
        noise = np.diag([sigma_m**2] * 3 + [sigma_mps**2] * 3)
        gain = np.linalg.solve(p[:TILT, :TILT] + noise, p[:TILT]).T
        keep = np.eye(ERRORS)
        keep[:, :TILT] -= gain
        self.covariance = np.ascontiguousarray(keep @ p @ keep.T + gain @ noise @ gain.T)
        self._correct(gain @ off, scale)

    def _correct(self, x: Floats, scale: Floats) -> None:
        state = self.state
        state[LATITUDE] -= x[0] / scale[0]
        state[LONGITUDE] -= x[1] / scale[1]
        state[HEIGHT] -= x[2] / scale[2]
        state[VELOCITY:QUATERNION] -= x[SPEED:TILT]
        state[QUATERNION : QUATERNION + 4] = turned_by(state[QUATERNION : QUATERNION + 4], x[TILT:BIAS_G])
        self.bias += x[BIAS_G:]


def turned_by(q: Floats, angles: Floats) -> Floats:
    """q(φ) ⊗ q for a rotation vector φ (rad) in north-east-down."""
    size = float(np.linalg.norm(angles))
    w = math.cos(0.5 * size)
    x, y, z = (0.5 * float(np.sinc(0.5 * size / math.pi)) * angles).tolist()
    a, b, c, d = q.tolist()
    turned = np.array(
        [
            w * a - x * b - y * c - z * d,
            w * b + x * a + y * d - z * c,
            w * c - x * d + y * a + z * b,
            w * d + x * c - y * b + z * a,
        ]
    )
    return turned / np.linalg.norm(turned)
