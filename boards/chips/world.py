"""What a chip feels: the world face of the chip models.

A chip asks for physical quantities in its own axes and SI units at its own sample instants; it then
quantises, filters, times and sends them. The world knows motion, sensor errors, satellites and outages.
Frames: navigation north-east-down, angles in radians, WGS-84; times are virtual time in integer ns since
the start of the run, unless a name says otherwise.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray


class ImuWorld(Protocol):
    """The motion that one inertial sensor feels, with that sensor's own errors."""

    def sample(self, times_ns: NDArray[np.int64], bandwidth_hz: float) -> NDArray[np.float64]:
        """Instantaneous values at `times_ns`, shape (n, 7).

        Columns: specific force x, y, z in m/s², angular rate x, y, z in rad/s, temperature in °C, in the
        chip's own axes. `bandwidth_hz` is the noise bandwidth of the chip's filter: white noise of
        density n per √Hz comes out with σ = n √bandwidth.

        `times_ns` rises strictly within one call. A later call may start earlier than the previous one
        ended when the chip was reconfigured, by at most eight seconds.

        A world whose motion is not decided for all time has an attribute `most_ahead_s`: a chip asks for no
        more than that at once.
        """
        ...


class CompassWorld(Protocol):
    """What a tilt-compensated compass feels, with its own errors."""

    def sample(self, times_ns: NDArray[np.int64]) -> NDArray[np.float64]:
        """Instantaneous values at `times_ns`, shape (n, 7).

        Columns: specific force x, y, z in m/s², magnetic flux density x, y, z in T, temperature in °C, in the
        chip's own axes. `times_ns` rises strictly, also from call to call.

        A world may have `foresee(times_ns)`: it is told which instants will be asked for one by one.
        """
        ...


class TenDofWorld(Protocol):
    """What a sensor of rate, force, magnetic field and pressure feels, with its own errors."""

    def sample(self, times_ns: NDArray[np.int64], bandwidth_hz: float) -> NDArray[np.float64]:
        """Instantaneous values at `times_ns`, shape (n, 11).

        Columns: those of `ImuWorld.sample`, to which all said there applies, then magnetic flux density
        x, y, z in T in the chip's own axes, and static pressure in Pa.
        """
        ...


@dataclass(frozen=True, slots=True)
class Satellite:
    """One satellite in view. `cn0_dbhz` is 0 when it is not tracked; numbers are those of NMEA 4.0."""

    system: str
    """ "GPS", "GLONASS", "GALILEO", "BEIDOU" or "SBAS"."""
    number: int
    elevation: float
    azimuth: float
    cn0_dbhz: float
    used: bool


@dataclass(frozen=True, slots=True)
class BaselineSolution:
    """The vector from a receiver's main antenna to its second one, or the lack of it (`fix` "NONE").

    It is the direction of the baseline, not of the body: who reports a body's angles knows how the antennas
    sit. Antennas along the body's forward axis: heading and pitch are the body's.
    """

    fix: Literal["NONE", "FLOAT", "FIXED"]
    """Carrier ambiguities: unknown, estimated as real numbers (errors far larger), as whole ones."""
    heading: float
    """rad from true north, 0 … 2π, clockwise."""
    pitch: float
    """rad, −π/2 … π/2, positive when the second antenna is higher."""
    length: float
    """m, as estimated."""
    heading_acc: float
    pitch_acc: float
    length_acc: float
    """1 σ accuracies that the receiver claims: rad, rad, m."""


@dataclass(frozen=True, slots=True)
class GnssEpoch:
    """A receiver's navigation solution valid at one instant, or the lack of one (`fix` False)."""

    fix: bool
    time_known: bool
    gps_time_ns: int
    """GPS time since 1980-01-06 00:00, ns, as the receiver believes it."""
    leap_seconds: int
    latitude: float
    longitude: float
    height: float
    """m above the ellipsoid."""
    geoid_separation: float
    """m; mean sea level = height − geoid_separation."""
    velocity_ned: tuple[float, float, float]
    h_acc: float
    v_acc: float
    s_acc: float
    """1 σ accuracies that the receiver claims: m, m, m/s."""
    pdop: float
    hdop: float
    vdop: float
    tdop: float
    satellites: tuple[Satellite, ...]
    latency_ns: int
    """From the instant of validity to the first byte of output."""
    baseline: BaselineSolution | None = None
    """None: the receiver has one antenna."""


class GnssWorld(Protocol):
    """What one receiver would compute at its antenna."""

    def epoch(self, time_ns: int) -> GnssEpoch:
        """The solution valid at `time_ns`; calls come in rising time."""
        ...
