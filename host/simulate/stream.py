"""A simulated drive as blocks of inertial samples with their truth, and receiver epochs between them.

A sample is either what the sensor feels at its instant, or the mean since the instant before: the integral of
the true rates by Boole's rule on quarters of the interval (error below 1e-12 of what a 20 Hz vibration leaves
at 200 Hz), to which the same error model is applied. Increments are means times the interval. White noise is
that of a density over half the sample rate, whichever of these it is.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from boards.chips.world import GnssEpoch, GnssWorld
from host.record.errors import UserError
from host.sim.errors.sensor_kernel import move_forces
from host.sim.gnss.faults import GNSS_FAULT_KINDS, glitches_of, refuse_baseline_faults
from host.sim.gnss.glitched import GlitchedReceiver
from host.sim.magnetic_field import MagneticField
from host.sim.scenario.errors import ScenarioError, named
from host.sim.scenario.schema import Scenario
from host.sim.simulated import SimulatedVehicle
from host.sim.trajectory.joints import Joints, examine
from host.sim.trajectory.kinematics import C_NB, FORCE, HEIGHT, LATITUDE, OMEGA_DOT, OMEGA_IB
from host.simulate.ambient import Ambient, Barometer, Magnetometer
from host.simulate.attitude_forms import matrices, quaternions
from host.simulate.baseline_rows import BASELINE, BASELINE_NAME, baseline_rows
from host.simulate.convention import Convention
from host.simulate.instants import NS, count_within, instants
from host.simulate.source import SideTable

BLOCK = 4096
"""Samples at a time: little enough for the processor's cache."""
IMU, RECEIVER = "imu", "gnss"
POLEMOST = math.radians(89.9)
LOWEST_M, HIGHEST_M = -1000.0, 100_000.0
BOOLE = np.array([7.0, 32.0, 12.0, 32.0, 7.0]) / 90.0

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Block:
    """Consecutive samples."""

    times_ns: NDArray[np.int64]
    felt: Floats
    """(n, 7): specific force x, y, z m/s², angular rate x, y, z rad/s (or increments m/s, rad), °C."""
    truth: Floats
    """(n, 24): rows of truth at `times_ns`, columns as in `host.sim.trajectory.kinematics`; their force and
    rate are what an error-free sensor gives."""


@dataclass(frozen=True, slots=True)
class Request:
    """What is to be simulated."""

    scenario: Scenario
    seed: int = 1
    rate_hz: Fraction = Fraction(200)
    gnss_rate_hz: Fraction = Fraction(1)
    """0: no receiver."""
    convention: Convention = Convention.INSTANT
    antenna_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    sensor_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Where the inertial sensor sits, body axes."""
    mounting_rad: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Yaw, pitch, roll of its axes against the body's."""
    second_antenna_m: tuple[float, float, float] | None = None
    """Of a receiver with two."""
    magnetometer_hz: Fraction = Fraction(0)
    barometer_hz: Fraction = Fraction(0)


class Drive:
    """One simulated drive. ScenarioError when the scenario's motion is impossible."""

    def __init__(self, request: Request) -> None:
        self.request = request
        self._vehicle = SimulatedVehicle(request.scenario, request.seed)
        mounting = matrices(quaternions(np.array([request.mounting_rad])))[0].reshape(3, 3)
        self._imu = self._vehicle.imu(IMU, mounting, np.zeros(3))
        self.duration_ns = self._vehicle.duration_ns
        self._receiver = _receiver(request, self._vehicle)
        self._intervals = count_within(request.rate_hz, self.duration_ns)
        rate = request.gnss_rate_hz
        self.epochs = count_within(rate, self.duration_ns) + 1 if rate else 0
        self.ambients = tuple(_ambients(request))

    @property
    def side_tables(self) -> tuple[SideTable, ...]:
        """Of magnetometer, barometer and the two antennas' baseline, where there are."""
        tables = [SideTable(one.sensor.name, one.sensor.table) for one in self.ambients]
        if self.request.second_antenna_m is not None and self.epochs:
            tables.append(SideTable(BASELINE_NAME, BASELINE))
        return tuple(tables)

    @property
    def samples(self) -> int:
        """How many samples it has: at time 0 too when they are instants."""
        return self._intervals + (self.request.convention is Convention.INSTANT)

    def joints(self) -> Joints:
        """How smooth the path is."""
        return examine(self._vehicle.motion.channels)

    @property
    def convention(self) -> Convention:
        """What a sample stands for."""
        return self.request.convention

    @property
    def start_gps_ns(self) -> int:
        """GPS time of the start."""
        return self.request.scenario.start.gps_time_ns

    def blocks(self) -> Iterator[Block]:
        """All samples, in order."""
        at_once = self.request.convention is Convention.INSTANT
        for first in range(0, self.samples, BLOCK):
            count = min(BLOCK, self.samples - first)
            block = self._instants(first, count) if at_once else self._means(first, count)
            self._check_place(block)
            yield block

    def _check_place(self, block: Block) -> None:
        """Raises ScenarioError when the drive leaves the Earth as it is computed here."""
        latitude, height = block.truth[:, LATITUDE], block.truth[:, HEIGHT]
        near = latitude.min() >= -POLEMOST and latitude.max() <= POLEMOST
        if near and height.min() >= LOWEST_M and height.max() <= HIGHEST_M:
            return
        inside = (np.abs(latitude) <= POLEMOST) & (height >= LOWEST_M) & (height <= HIGHEST_M)
        k = int(np.argmin(inside))
        scenario = self.request.scenario
        raise ScenarioError(
            f"{scenario.path or scenario.name}: at {block.times_ns[k] / NS:g} s the drive is at latitude"
            f" {math.degrees(latitude[k]):.6g}°, height {height[k]:,.0f} m; it must keep within"
            f" ±{math.degrees(POLEMOST):g}° and {LOWEST_M:,.0f} … {HIGHEST_M:,.0f} m: end it before, for"
            f" example by duration_s = {max(1, block.times_ns[k] // NS)}.0"
        )

    def receiver_epochs(self) -> Iterator[tuple[int, GnssEpoch]]:
        """(time of validity in ns, epoch), in order."""
        for first in range(0, self.epochs, BLOCK):
            count = min(BLOCK, self.epochs - first)
            for time_ns in instants(self.request.gnss_rate_hz, first, count).tolist():
                yield time_ns, self._receiver.epoch(time_ns)

    def baseline_rows(self, epochs: Sequence[tuple[int, GnssEpoch]]) -> Floats:
        """Rows of the baseline's table for epochs of this drive, beside the truth."""
        times_ns = np.array([time_ns for time_ns, _ in epochs], dtype=np.int64)
        c_nb = self._vehicle.motion.rows(times_ns)[:, C_NB : C_NB + 9].reshape(-1, 3, 3)
        assert self.request.second_antenna_m is not None
        arm = np.array(self.request.second_antenna_m) - np.array(self.request.antenna_m)
        return baseline_rows(epochs, c_nb @ arm)

    def ambient_rows(self, ambient: Ambient, after_ns: int, end_ns: int) -> Floats:
        """Rows of a magnetometer or barometer at its instants after one time (−1: from the first on) and up
        to another; to be asked for in order."""
        rate = ambient.rate_hz
        first = 0 if after_ns < 0 else count_within(rate, after_ns) + 1
        times_ns = instants(rate, first, max(0, count_within(rate, end_ns) + 1 - first))
        return ambient.sensor.rows(times_ns, self._vehicle.motion.rows(times_ns))

    @property
    def _bandwidth_hz(self) -> float:
        return float(self.request.rate_hz) / 2.0

    def _instants(self, first: int, count: int) -> Block:
        times_ns = instants(self.request.rate_hz, first, count)
        rows = self._rows(times_ns)
        return Block(times_ns, self._imu.measured(times_ns, rows, self._bandwidth_hz), rows)

    def _rows(self, times_ns: NDArray[np.int64]) -> Floats:
        """Rows of truth whose force is that at the sensor's place."""
        rows = self._vehicle.motion.rows(times_ns)
        if any(self.request.sensor_m):
            move_forces(np.array(self.request.sensor_m), rows)
        return rows

    def _means(self, first: int, count: int) -> Block:
        fine_ns = instants(4 * self.request.rate_hz, 4 * first, 4 * count + 1)
        fine = self._rows(fine_ns)
        times_ns, rows = np.ascontiguousarray(fine_ns[4::4]), np.ascontiguousarray(fine[4::4])
        signals = slice(OMEGA_IB, OMEGA_DOT)
        assert OMEGA_IB < FORCE < OMEGA_DOT
        rows[:, signals] = sum(
            weight * fine[k : 4 * count - 3 + k : 4, signals] for k, weight in enumerate(BOOLE.tolist())
        )
        felt = self._imu.measured(times_ns, rows, self._bandwidth_hz)
        if self.request.convention is Convention.INCREMENT:
            lengths = (np.diff(fine_ns[::4]) / NS)[:, None]
            felt[:, :6] *= lengths
            rows[:, signals] *= lengths
        return Block(times_ns, felt, rows)


def _receiver(request: Request, vehicle: SimulatedVehicle) -> GnssWorld:
    """The receiver with all faults of the scenario that strike one, whatever it is called there."""
    second = None if request.second_antenna_m is None else np.array(request.second_antenna_m)
    receiver = vehicle.gnss(RECEIVER, np.array(request.antenna_m), second)
    faults = [fault for fault in request.scenario.fault if fault.kind in GNSS_FAULT_KINDS]
    struck = [fault.model_copy(update={"target": RECEIVER}) for fault in faults]
    with named(request.scenario.path, request.scenario.name):
        for fault in faults if second is None else ():
            refuse_baseline_faults([fault], fault.target)
        glitches = glitches_of(struck, RECEIVER, vehicle.duration_ns, request.seed)
    return GlitchedReceiver(receiver, glitches) if glitches else receiver


def _ambients(request: Request) -> Iterator[Ambient]:
    scenario = request.scenario
    if request.magnetometer_hz:
        try:
            field = MagneticField(scenario.start.utc)
        except UserError as error:
            raise UserError(f"{scenario.path or scenario.name}: {error}") from None
        yield Ambient(Magnetometer(scenario.magnetometer, field, request.seed), request.magnetometer_hz)
    if request.barometer_hz:
        assert scenario.place is not None  # the schema asks for it
        separation = scenario.place.geoid_separation_m
        yield Ambient(Barometer(scenario.barometer, separation, request.seed), request.barometer_hz)


def warm_up(request: Request) -> None:
    """Have all kernels of such a drive loaded, so that its time is that of its samples."""
    other = Drive(request)
    next(other.blocks(), None)
    next(other.receiver_epochs(), None)
