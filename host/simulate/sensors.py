"""Sensors with errors along a trajectory that came from a file."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from host.sim.earth import EARTH_RATE
from host.sim.errors.drawn import draw_specimen
from host.sim.errors.inertial_sensor import InertialSensor
from host.sim.errors.presets import load_preset, with_overrides
from host.sim.gnss.receiver import SimulatedReceiver
from host.sim.gnss.schedule import window
from host.sim.scenario.schema import Scenario
from host.sim.trajectory.antenna import move_rows
from host.sim.trajectory.kinematics import C_NB, FORCE, OMEGA_IB, ROW
from host.simulate.attitude_forms import matrices, quaternions
from host.simulate.epochs import Epoch
from host.simulate.flyable import Flyable
from host.simulate.instants import NS, count_within, instants
from host.simulate.stream import IMU, RECEIVER

Floats = NDArray[np.float64]
NO_ERRORS = "perfect"
APART_S = 1e-3
"""Attitudes so far before and after an instant tell its turn rate; transport rate, 1e-6 rad/s, left out."""


class TrackSensors:
    """An inertial sensor at the vehicle's origin and a receiver whose antenna is `antenna_m` (body axes) away
    from it, with the errors that a scenario tells."""

    def __init__(
        self,
        scenario: Scenario,
        seed: int,
        motion: Flyable,
        start_gps_ns: int,
        antenna_m: tuple[float, float, float] = (0.0, 0.0, 0.0),
    ) -> None:
        base = load_preset(scenario.imu.preset or NO_ERRORS)
        specimen = draw_specimen(with_overrides(base, scenario.imu), seed, IMU)
        self._imu = InertialSensor(None, specimen, seed, IMU, np.eye(3), np.zeros(3))
        self._receiver = SimulatedReceiver(
            RECEIVER,
            scenario.gnss,
            lambda times_ns: antenna_places(motion, times_ns / NS, np.array(antenna_m)),
            start_gps_ns,
            scenario.start.leap_seconds,
            0.0 if scenario.place is None else scenario.place.geoid_separation_m,
            seed,
            [window(outage.start_s, outage.duration_s) for outage in scenario.outage],
        )

    def felt(self, times_ns: NDArray[np.int64], rows: Floats, rate_hz: Fraction) -> Floats:
        """Measured force, rate and temperature (n, 7) from rows of truth with mean force and rate."""
        return self._imu.measured(times_ns, rows, float(rate_hz) / 2.0)

    def epochs(self, rate_hz: Fraction, duration_ns: int) -> Iterator[Epoch]:
        """Solutions of the receiver; none at a rate of 0."""
        count = count_within(rate_hz, duration_ns) + 1 if rate_hz else 0
        for k in range(count):
            time_ns = int(instants(rate_hz, k, 1)[0])
            yield time_ns, self._receiver.epoch(time_ns)


def antenna_places(motion: Flyable, t_s: Floats, lever_m: Floats) -> Floats:
    """Position and velocity (n, 6) of a point of the body (source 002, eqs. 3-45 and 3-46)."""
    here = motion.motion(t_s)
    if not lever_m.any():
        return here[:, :6]
    rows = np.zeros((len(t_s), ROW))
    rows[:, :6] = here[:, :6]
    c_nb = _turned(here)
    before, after = (_turned(motion.motion(np.clip(t_s + d, 0.0, motion.end_s))) for d in (-APART_S, APART_S))
    apart = np.minimum(t_s + APART_S, motion.end_s) - np.maximum(t_s - APART_S, 0.0)
    change = np.einsum("nji,njk->nik", before, after)
    turning = 0.5 * np.column_stack([change[:, j, k] - change[:, k, j] for j, k in ((2, 1), (0, 2), (1, 0))])
    cosine, sine = np.cos(here[:, 0]), np.sin(here[:, 0])
    earth = EARTH_RATE * np.column_stack((cosine, np.zeros_like(cosine), -sine))
    rows[:, C_NB:OMEGA_IB] = c_nb.reshape(-1, 9)
    rows[:, OMEGA_IB:FORCE] = turning / apart[:, None] + np.einsum("nji,nj->ni", c_nb, earth)
    move_rows(rows, lever_m)
    return rows[:, :6]


def _turned(states: Floats) -> Floats:
    return matrices(quaternions(states[:, 6:9])).reshape(-1, 3, 3)
