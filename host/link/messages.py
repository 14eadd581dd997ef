"""What the board says, by name: one type for each frame of `docs/link.md`.

Every message is the plain tuple of its numbers as they stand on the wire, with names: board time in µs since
reset, positions in nanodegrees, angles in rad, lengths in m, unless a field's name has a unit.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from firmware.drivers.satellite_lists import SatelliteInView
from host.link.raw import RawInput, RawSlice, RawWanted

DYNAMIC_STATES = 9
"""δr NED, δv NED, φ in n."""


class Solution(NamedTuple):
    """The navigation solution at `time_us`, of a SOLUTION or an ATTITUDE frame.

    The latter tells no UTC and no sigmas (NaN); its flags stand from bit 16 on.
    """

    time_us: int
    time_of_day_ms: int
    date_days: int
    mode: int
    flags: int
    lat_nanodeg: int
    lon_nanodeg: int
    height: float
    v_n: float
    v_e: float
    v_d: float
    yaw: float
    pitch: float
    roll: float
    omega_x: float
    omega_y: float
    omega_z: float
    sigma_n: float
    sigma_e: float
    sigma_d: float
    sigma_v_n: float
    sigma_v_e: float
    sigma_v_d: float
    sigma_phi_n: float
    sigma_phi_e: float
    sigma_phi_d: float


class Covariance(tuple[float, ...]):
    """Covariance of [δr NED m, δv NED m/s, φ rad]: time, then the upper triangle row by row (45)."""

    __slots__ = ()

    @property
    def time_us(self) -> int:
        """Board time."""
        return int(self[0])

    def matrix(self) -> NDArray[np.float64]:
        """(9, 9), symmetric."""
        upper = np.zeros((DYNAMIC_STATES, DYNAMIC_STATES))
        upper[np.triu_indices(DYNAMIC_STATES)] = self[1:]
        return upper + np.triu(upper, 1).T


class Innovation(tuple[float, ...]):
    """Innovations of a GNSS update: time of validity, mask of used components, 6 innovations, 6 sigmas."""

    __slots__ = ()

    @property
    def time_us(self) -> int:
        """Board time of validity."""
        return int(self[0])

    @property
    def used(self) -> int:
        """Bit i is set when component i was used."""
        return int(self[1])

    @property
    def values(self) -> tuple[float, ...]:
        """Position NED in m; velocity NED, or along and across the course, in m/s."""
        return self[2:8]

    @property
    def sigmas(self) -> tuple[float, ...]:
        """√S of each."""
        return self[8:14]


class Bias(tuple[float, ...]):
    """Slow states: time, b_g rad/s (3), b_a m/s² (3), mounting yaw and pitch rad, latency s; 9 sigmas."""

    __slots__ = ()

    @property
    def time_us(self) -> int:
        """Board time."""
        return int(self[0])

    @property
    def values(self) -> tuple[float, ...]:
        """The nine estimates."""
        return self[1:10]

    @property
    def sigmas(self) -> tuple[float, ...]:
        """Their sigmas."""
        return self[10:19]


class Status(NamedTuple):
    """How the board is."""

    time_us: int
    mode: int
    flags: int
    gnss_epochs: int
    imu_reads: int
    samples_missed: int
    samples_repeated: int
    bad_checksums: int
    garbage_bytes: int
    frames_dropped: int
    imu_starts: int
    pulse_dated: int


class Gnss(NamedTuple):
    """One epoch of the receiver as the board parsed it; flags as in `firmware.drivers.gnss_epoch`."""

    time_us: int
    time_of_day_ms: int
    date_days: int
    flags: int
    lat_nanodeg: int
    lon_nanodeg: int
    height_mm: int
    height_msl_mm: int
    speed_mmps: int
    course_e5deg: int
    v_n_mmps: int
    v_e_mmps: int
    v_d_mmps: int
    satellites: int
    hdop_centi: int
    h_acc_mm: int
    v_acc_mm: int


class FilterState(NamedTuple):
    """What one of several filters side by side takes for the state, and how sure it is (1 σ)."""

    time_us: int
    filter: int
    """0, 1, … in the board's order."""
    status: int
    """0: trusted; 1: isolated."""
    lat_nanodeg: int
    lon_nanodeg: int
    height: float
    v_north: float
    v_east: float
    v_down: float
    yaw: float
    pitch: float
    roll: float
    sigma_north: float
    sigma_east: float
    sigma_down: float
    sigma_v_north: float
    sigma_v_east: float
    sigma_v_down: float
    sigma_psi_n: float
    sigma_psi_e: float
    sigma_psi_d: float


class Sensor(NamedTuple):
    """How the inertial sensor is, and how often which trouble was noticed since the board's reset."""

    time_us: int
    supply_mv: int
    diagnosis: int
    """DIAG_STAT, all flags since the last such frame."""
    temperature_centi_c: int
    pressure_pa: int
    field_nt: int
    """Magnitude."""
    adc_mv: int
    age_least_us: int
    """Of the samples of solutions since the last such frame; 0xFFFF: not known."""
    age_most_us: int
    product_id: int
    starts: int
    bursts: int
    jumps: int
    lost_reads: int
    stale: int
    chip_error: int
    supply: int
    gyro_saturated: int
    no_answer: int
    slipped: int
    field_implausible: int
    bridged: int
    moved: int
    rates_lost: int
    overrun: int
    yaw_given: int
    saturated_rate: int
    saturated_force: int
    saturated_field: int
    saturated_angle: int
    saturated_attitude: int
    saturated_velocity: int
    saturated_earth: int
    saturated_height: int


class TaskFigures(NamedTuple):
    """One task of the firmware."""

    name: str
    activations: int
    busy_us: int
    """Time worked so far, modulo 2³²."""
    worst_response_us: int
    deadlines_missed: int


class Tasks(NamedTuple):
    """Figures of some or all tasks."""

    time_us: int
    tasks: tuple[TaskFigures, ...]


class Satellites(NamedTuple):
    """Satellites in view, part `number` of `frames`."""

    time_us: int
    number: int
    frames: int
    satellites: tuple[SatelliteInView, ...]


Message = (
    Solution
    | Covariance
    | Innovation
    | Bias
    | Status
    | Gnss
    | Sensor
    | FilterState
    | Tasks
    | Satellites
    | RawInput
    | RawSlice
    | RawWanted
    | str
)
"""A str is a TEXT, or an NMEA sentence."""

SOLUTION_DTYPE = np.dtype(
    [
        ("time_us", "<u8"),
        ("time_of_day_ms", "<u4"),
        ("date_days", "<u2"),
        ("mode", "u1"),
        ("flags", "<u2"),
        ("lat_nanodeg", "<i8"),
        ("lon_nanodeg", "<i8"),
        ("height", "<f4"),
        ("velocity_ned", "<f4", 3),
        ("yaw", "<f4"),
        ("pitch", "<f4"),
        ("roll", "<f4"),
        ("omega_b", "<f4", 3),
        ("sigma_position", "<f4", 3),
        ("sigma_velocity", "<f4", 3),
        ("sigma_attitude", "<f4", 3),
    ]
)
"""SOLUTION payloads one after the other, for many at once."""


def solution_array(payloads: list[bytes]) -> NDArray[np.void]:
    """Many SOLUTION payloads as one structured array of SOLUTION_DTYPE."""
    return np.frombuffer(b"".join(payloads), SOLUTION_DTYPE)
