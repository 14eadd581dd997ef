"""Truth against answers that are known on paper; WGS-84 and its gravity are written down once more here.

Each figure is the largest relative error of force, rate and place over a few instants.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from host.sim.scenario.load import scenario_from
from host.sim.simulated import SimulatedVehicle
from host.sim.trajectory.motion import Motion
from host.sim.trajectory.piece import Piece, wave
from host.sim.trajectory.segments import MotionState, SegmentRates
from host.simulate.proof.figure import Figure
from host.simulate.proof.noise import rest
from host.simulate.proof.scenes import NS, PLACE

Floats = NDArray[np.float64]
A, F, W = 6378137.0, 1.0 / 298.257223563, 7.292115e-5
E2 = F * (2.0 - F)
DEG = math.pi / 180.0
LIMIT = 1e-9


def figures() -> Iterator[Figure]:
    """Rest, great circle, coning, sculling."""
    for what, error in (
        ("rest on the turning Earth", _rest()),
        ("great circle at constant speed", _great_circle()),
        ("pure coning", _coning()),
        ("pure sculling", _sculling()),
    ):
        yield Figure("closed forms", f"{what}: relative error", "", error, most=LIMIT)


def normal_gravity(latitude: float, height: float) -> float:
    """Somigliana's formula with height, NIMA TR8350.2, eqs. 4-1 and 4-3."""
    sine2 = math.sin(latitude) ** 2
    b = A * (1.0 - F)
    k = b * 9.8321849378 / (A * 9.7803253359) - 1.0
    m = W * W * A * A * b / 3.986004418e14
    at_sea: float = 9.7803253359 * (1.0 + k * sine2) / math.sqrt(1.0 - E2 * sine2)
    return at_sea * (1.0 - 2.0 / A * (1.0 + F + m - 2.0 * F * sine2) * height + 3.0 * height**2 / A**2)


def _rows(tables: dict[str, Any], *t_s: float) -> Floats:
    scenario = scenario_from({"imu": {"preset": "perfect"}, **tables}, "paper", "paper")
    times_ns = np.array([round(t * NS) for t in t_s], dtype=np.int64)
    return SimulatedVehicle(scenario, 1).motion.rows(times_ns)


def _off(found: Floats, expected: Floats) -> float:
    return float(np.linalg.norm(found - expected) / np.linalg.norm(expected))


def _rest() -> float:
    initial = {"yaw_deg": 63.0, "pitch_deg": 11.0, "roll_deg": -17.0}
    vehicle = SimulatedVehicle(rest(200.0, initial=initial, imu={"preset": "perfect"}), 1)
    row = vehicle.motion.rows(np.array([100 * NS]))[0]
    latitude = PLACE["latitude_deg"] * DEG
    yaw, pitch, roll = (angle * DEG for angle in (63.0, 11.0, -17.0))
    gravity = normal_gravity(latitude, PLACE["height_m"])
    parts = (math.sin(pitch), -math.cos(pitch) * math.sin(roll), -math.cos(pitch) * math.cos(roll))
    earth = np.array([W * math.cos(latitude), 0.0, -W * math.sin(latitude)])
    c_nb = _matrix(yaw, pitch, roll)
    return max(_off(row[18:21], gravity * np.array(parts)), _off(row[15:18], c_nb.T @ earth))


def _matrix(yaw: float, pitch: float, roll: float) -> Floats:
    (cy, sy), (cp, sp), (cr, sr) = ((math.cos(x), math.sin(x)) for x in (yaw, pitch, roll))
    about_z = np.array([[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]])
    about_y = np.array([[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]])
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]])
    turned: Floats = about_z @ about_y @ about_x
    return turned


def _great_circle() -> float:
    """Eastwards along the equator."""
    speed, height, t = 250.0, 1000.0, 600.0
    place = {"latitude_deg": 0.0, "longitude_deg": 10.0, "height_m": height}
    cruise = [{"kind": "cruise", "duration_s": 700.0}]
    (row,) = _rows({"place": place, "segment": cruise, "initial": {"speed_mps": speed, "yaw_deg": 90.0}}, t)
    radius = A + height
    total = W + speed / radius
    up = normal_gravity(0.0, height) - (total**2 - W**2) * radius
    way = (row[1] - 10.0 * DEG) * radius
    return max(
        abs(way / (speed * t) - 1.0), abs(-row[20] / up - 1.0), _off(row[15:18], np.array([0.0, -total, 0.0]))
    )


def _coning() -> float:
    """ω = (−Ω sin α sin Ωt, Ω sin α cos Ωt, −2 Ω sin² α/2) and the Earth's turn, in body axes."""
    half_deg, frequency = 0.5, 5.0
    shaking = {"coning_deg": half_deg, "coning_hz": frequency, "always": True}
    instants = (0.0, 1.237, 77.00123)
    segment = [{"kind": "rest", "duration_s": 100.0}]
    rows = _rows({"place": PLACE, "segment": segment, "vibration": shaking}, *instants)
    alpha, k = half_deg * DEG, 2.0 * math.pi * frequency
    latitude = PLACE["latitude_deg"] * DEG
    earth = np.array([W * math.cos(latitude), 0.0, -W * math.sin(latitude)])
    worst = 0.0
    for row, t in zip(rows, instants, strict=True):
        sine, cosine = math.sin(k * t), math.cos(k * t)
        turning = [
            -k * math.sin(alpha) * sine,
            k * math.sin(alpha) * cosine,
            -2.0 * k * math.sin(alpha / 2) ** 2,
        ]
        worst = max(worst, _off(row[15:18], np.array(turning) + row[6:15].reshape(3, 3).T @ earth))
    return worst


@dataclass(frozen=True)
class _Swing:
    """Acceleration a cos Ωt along x and pitch b (1 + cos Ωt)."""

    duration_s: float
    acceleration: float
    angle: float
    rate: float

    def rates(self, speed: float, blend_s: float) -> SegmentRates:
        """Without flanks, whatever the blend."""
        along = wave(self.duration_s, self.acceleration, 2.0 * math.pi / self.rate, 0.5 * math.pi)
        swing = Piece(self.duration_s, (0.0,), (0.0,), (self.angle,), self.rate)
        return SegmentRates([along], pitch_course=[swing])


def _sculling() -> float:
    """On the equator heading north: v̇ and ω × v in the plane of north and down, which itself turns with the
    meridian, and gravity."""
    a, b, k = 5.0, 2.0 * DEG, 2.0 * math.pi * 3.0
    motion = Motion([_Swing(100.0, a, b, k)], MotionState(0.0, 0.0, b), (0.0, 0.0, 50.0))
    worst = 0.0
    for t in (0.0, 1.2345, 61.00017):
        (row,) = motion.rows(np.array([round(t * NS)]))
        speed, gained = a / k * math.sin(k * t), a * math.cos(k * t)
        pitch, pitching = b + b * math.cos(k * t), -b * k * math.sin(k * t)
        sine, cosine = math.sin(pitch), math.cos(pitch)
        north, down = speed * cosine, -speed * sine
        meridian = A * (1.0 - E2) / (1.0 - E2 * math.sin(row[0]) ** 2) ** 1.5 + row[2]
        curve = -north / meridian
        ahead = gained * cosine - speed * sine * pitching + curve * down
        below = -(gained * sine + speed * cosine * pitching) - curve * north - normal_gravity(row[0], row[2])
        force = np.array([ahead * cosine - below * sine, ahead * sine + below * cosine])
        worst = max(worst, _off(row[[18, 20]], force), abs(row[16] - (pitching + curve)) / (b * k))
    return worst
