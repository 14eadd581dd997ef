"""Reader of a comma2k19 example (comma.ai, MIT): phone-grade IMU, u-blox GNSS, camera-based reference.

All times are seconds on one boot clock. The device frame is forward-right-down, which serves as body frame;
the reference is the camera's pose in the same frame (v_ecef = R(q) v_frd). Altitudes are above the ellipsoid.

The GNSS rows carry UTC, truncated to ms (… 99, 199 …), and their time of arrival on the boot clock; the true
instant of validity on the boot clock is known up to a constant only. Against the reference the positions fit
best when they are taken 0.08 s before their arrival on average (0.46 m RMS then, 1.47 m at the arrival), so

    validity = UTC + K,   K = median(arrival − UTC) − 0.08 s,

which leaves the receiver's own jitter (9 ms RMS) in arrival − validity.
"""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from host.sim.scenario.errors import ScenarioError
from host.sim.scenario.schema import GPS_EPOCH

Array = NDArray[np.float64]
MEAN_LATENCY_S = 0.08
LEAP_SECONDS = 18
"""Since 2017; the recordings are of 2018."""
VERTICAL_SPAN_S = 0.5
"""Vertical velocity comes from the altitudes this long before and after an epoch."""


@dataclass(frozen=True)
class Comma2k19:
    """One drive; times in s on the boot clock."""

    imu_t: Array
    force: Array
    """(n, 3) m/s², device frame."""
    rate: Array
    """(n, 3) rad/s, device frame."""
    gnss_valid_t: Array
    gnss_arrival_t: Array
    gnss_gps_ms: NDArray[np.int64]
    """GPS time of validity since 1980-01-06, ms."""
    gnss_position: Array
    """(m, 3) latitude, longitude in rad, height above the ellipsoid in m."""
    gnss_velocity: Array
    """(m, 3) north, east, down, m/s; down from the altitudes."""
    pose_t: Array
    pose_position: Array
    """(k, 3) ECEF, m."""
    pose_velocity: Array
    """(k, 3) ECEF, m/s."""
    pose_q_eb: Array
    """(k, 4) Hamilton, scalar first."""


KEYS = (
    "imu_accel_t",
    "imu_accel",
    "imu_gyro_t",
    "imu_gyro",
    "imu_gyro_calibrated",
    "gnss_t",
    "gnss",
    "pose_t",
    "pose_position_ecef",
    "pose_velocity_ecef",
    "pose_orientation_ecef",
)


def read_comma2k19(path: Path, calibrated_gyro: bool) -> Comma2k19:
    """Read the archive. ScenarioError when it is not a comma2k19 example."""
    try:
        with np.load(path, allow_pickle=False) as archive:
            missing = [key for key in KEYS if key not in archive.files]
            if missing:
                raise ScenarioError(
                    f"{path}: not a comma2k19 example, it lacks {', '.join(missing)}; "
                    'for example file = "comma2k19/example_1.npz"'
                )
            data = {key: np.asarray(archive[key], dtype=np.float64) for key in KEYS}
    except (OSError, ValueError, zipfile.BadZipFile) as error:
        if isinstance(error, ScenarioError):
            raise
        raise ScenarioError(f"{path}: cannot be read as a NumPy archive: {error}") from None
    return drive_of(data, calibrated_gyro)


def drive_of(data: Mapping[str, Array], calibrated_gyro: bool) -> Comma2k19:
    """The drive in the arrays of an example."""
    gyro = data["imu_gyro_calibrated" if calibrated_gyro else "imu_gyro"]
    gnss = data["gnss"]
    utc_ms = 100 * np.round(gnss[:, 3] / 100.0).astype(np.int64)
    utc_s: Array = utc_ms.astype(np.float64) * 1e-3
    valid_t: Array = utc_s + float(np.median(data["gnss_t"] - utc_s)) - MEAN_LATENCY_S
    unix_of_gps_ms = round((GPS_EPOCH - datetime(1970, 1, 1, tzinfo=UTC)).total_seconds()) * 1000
    return Comma2k19(
        imu_t=data["imu_accel_t"],
        force=data["imu_accel"],
        rate=_at_times(data["imu_gyro_t"], gyro, data["imu_accel_t"]),
        gnss_valid_t=valid_t,
        gnss_arrival_t=data["gnss_t"],
        gnss_gps_ms=utc_ms - unix_of_gps_ms + 1000 * LEAP_SECONDS,
        gnss_position=np.column_stack((np.radians(gnss[:, 0]), np.radians(gnss[:, 1]), gnss[:, 4])),
        gnss_velocity=_velocity(valid_t, gnss[:, 2], np.radians(gnss[:, 5]), gnss[:, 4]),
        pose_t=data["pose_t"],
        pose_position=data["pose_position_ecef"],
        pose_velocity=data["pose_velocity_ecef"],
        pose_q_eb=data["pose_orientation_ecef"],
    )


def _at_times(t: Array, values: Array, wanted_t: Array) -> Array:
    return np.column_stack([np.interp(wanted_t, t, column) for column in values.T])


def _velocity(t: Array, speed: Array, bearing: Array, altitude: Array) -> Array:
    """North, east, down; down is the slope of the altitude over the span around each epoch."""
    before = np.maximum(t - VERTICAL_SPAN_S, t[0])
    after = np.minimum(t + VERTICAL_SPAN_S, t[-1])
    climb = (np.interp(after, t, altitude) - np.interp(before, t, altitude)) / (after - before)
    return np.column_stack((speed * np.cos(bearing), speed * np.sin(bearing), -climb))
