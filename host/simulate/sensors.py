"""Sensors with errors along a trajectory that came from a file."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from host.sim.errors.drawn import draw_specimen
from host.sim.errors.inertial_sensor import InertialSensor
from host.sim.errors.presets import load_preset, with_overrides
from host.sim.gnss.receiver import SimulatedReceiver
from host.sim.gnss.schedule import window
from host.sim.scenario.schema import Scenario
from host.simulate.attitude_forms import matrices, quaternions
from host.simulate.body_point import point_states
from host.simulate.epochs import Epoch
from host.simulate.flyable import Flyable
from host.simulate.instants import NS, count_within, instants
from host.simulate.places import AT_ORIGIN, Places
from host.simulate.stream import IMU, RECEIVER

Floats = NDArray[np.float64]
NO_ERRORS = "perfect"


class TrackSensors:
    """An inertial sensor and a receiver where they sit in the body, with the errors that a scenario tells."""

    def __init__(
        self,
        scenario: Scenario,
        seed: int,
        motion: Flyable,
        start_gps_ns: int,
        places: Places = AT_ORIGIN,
    ) -> None:
        self.places = places
        base = load_preset(scenario.imu.preset or NO_ERRORS)
        specimen = draw_specimen(with_overrides(base, scenario.imu), seed, IMU)
        mounting = matrices(quaternions(np.array([places.mounting_rad])))[0].reshape(3, 3)
        self._imu = InertialSensor(None, specimen, seed, IMU, mounting, np.zeros(3))
        antenna = np.array(places.antenna_m)
        self._receiver = SimulatedReceiver(
            RECEIVER,
            scenario.gnss,
            lambda times_ns: point_states(motion, times_ns / NS, antenna)[:, :6],
            start_gps_ns,
            scenario.start.leap_seconds,
            0.0 if scenario.place is None else scenario.place.geoid_separation_m,
            seed,
            [window(outage.start_s, outage.duration_s) for outage in scenario.outage],
        )

    def felt(self, times_ns: NDArray[np.int64], rows: Floats, rate_hz: Fraction) -> Floats:
        """Measured force, rate and temperature (n, 7) from rows with the true mean force and rate at the
        sensor's place, in body axes."""
        return self._imu.measured(times_ns, rows, float(rate_hz) / 2.0)

    def epochs(self, rate_hz: Fraction, duration_ns: int) -> Iterator[Epoch]:
        """Solutions of the receiver; none at a rate of 0."""
        count = count_within(rate_hz, duration_ns) + 1 if rate_hz else 0
        for k in range(count):
            time_ns = int(instants(rate_hz, k, 1)[0])
            yield time_ns, self._receiver.epoch(time_ns)
