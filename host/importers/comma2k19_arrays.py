"""comma2k19 examples (comma.ai, MIT) as arrays: phone-grade IMU, u-blox GNSS, camera-based reference.

What the arrays mean and how their clocks fit together stands in `host.sim.recording.comma2k19`, which a drive
of kind "recording" reads too: the boot clock of all times becomes GPS time through the receiver's UTC.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from host.importers import topics
from host.importers.findings import Kind
from host.importers.number_lines import ns_of_seconds
from host.importers.numpy_archive import arrays_of
from host.importers.request import Recording, Task, only_file
from host.importers.series import Floats, Integers, Rows, Stream, portions
from host.record.errors import UserError
from host.sim.recording.comma2k19 import LEAP_SECONDS, MEAN_LATENCY_S, Comma2k19, drive_of
from host.sim.recording.reference import PoseReference

SHAPES: dict[str, int | None] = {
    "imu_accel_t": None,
    "imu_accel": 3,
    "imu_gyro_t": None,
    "imu_gyro": 3,
    "imu_gyro_calibrated": 3,
    "gnss_t": None,
    "gnss": 6,
    "pose_t": None,
    "pose_position_ecef": 3,
    "pose_velocity_ecef": 3,
    "pose_orientation_ecef": 4,
}
OTHERS = (
    "mag_t",
    "mag",
    "car_speed_t",
    "car_speed",
    "wheel_speed_t",
    "wheel_speed",
    "steering_t",
    "steering",
)
PAIRS = {
    "imu_accel": "imu_accel_t",
    "imu_gyro": "imu_gyro_t",
    "imu_gyro_calibrated": "imu_gyro_t",
    "gnss": "gnss_t",
    "pose_position_ecef": "pose_t",
    "pose_velocity_ecef": "pose_t",
    "pose_orientation_ecef": "pose_t",
}
LATEST_S = 1e9
"""On a clock that began when the phone was switched on."""
EARTH_RADII_M = 6.0e6, 7.0e6


def read_comma2k19(task: Task) -> Recording:
    """IMU, receiver, reference, magnetometer, and what the car told."""
    file = only_file(task, "example_1.npz")
    data = arrays_of(file.path, SHAPES, OTHERS, "comma2k19")
    for key, clock in PAIRS.items():
        if len(data[key]) != len(data[clock]):
            raise UserError(f"{file.path}: {key} has {len(data[key])} rows and {clock} {len(data[clock])}")
    _drop_unsound(task, file.name, data)
    if len(data["imu_gyro_t"]) < 2 or len(data["gnss_t"]) < 2 or len(data["pose_t"]) < 2:
        told = "".join(f"\n- {line}" for line in task.findings.lines())
        raise UserError(f"{file.path}: has fewer than two sound rows of IMU, GNSS or pose{told}")
    task.meter(file.path.stat().st_size)
    drive = drive_of(data, calibrated_gyro=False)
    shift_ns = int(drive.gnss_gps_ms[0]) * 1_000_000 - int(ns_of_seconds(drive.gnss_valid_t[:1])[0])

    def gps(boot_t: Floats) -> Integers:
        return ns_of_seconds(boot_t) + shift_ns

    leaps = task.request.leap_seconds
    if leaps is not None and leaps != LEAP_SECONDS:
        raise UserError(
            f"--leap-seconds {leaps}: these recordings are of 2018, when there were {LEAP_SECONDS}"
        )
    streams = [
        _imu(task, file.name, data, gps(data["imu_accel_t"]), "imu", "imu_gyro"),
        _imu(task, file.name, data, gps(data["imu_accel_t"]), "calibrated", "imu_gyro_calibrated"),
        _gnss(file.name, drive, drive.gnss_gps_ms * 1_000_000),
        _truth(file.name, drive, gps(drive.pose_t)),
        *_others(task, file.name, data, gps),
    ]
    facts = {"gnss_valid_before_arrival_s": MEAN_LATENCY_S, "boot_clock_to_gps_ns": shift_ns}
    return Recording(streams, is_absolute=True, facts=facts)


def _drop_unsound(task: Task, file: str, data: dict[str, Floats]) -> None:
    """Clocks must rise and rows be numbers for the drive to be put together: what is not so is left out."""
    for clock in ("imu_gyro_t", "gnss_t", "pose_t"):
        owned = [key for key, one in PAIRS.items() if one == clock]
        sound = np.abs(data[clock]) < LATEST_S
        for key in owned:
            sound &= np.isfinite(data[key]).all(axis=1)
        if clock == "pose_t":
            radius = np.linalg.norm(data["pose_position_ecef"], axis=1)
            sound &= (radius > EARTH_RADII_M[0]) & (radius < EARTH_RADII_M[1])
            sound &= np.abs(np.linalg.norm(data["pose_orientation_ecef"], axis=1) - 1.0) < 0.1
        if clock == "gnss_t":
            sound &= (np.abs(data["gnss"][:, 0]) <= 90.0) & (data["gnss"][:, 3] > 0.0)
        _tell(task, file, clock, ~sound, Kind.NOT_FINITE, data[clock])
        t = np.where(sound, data[clock], -np.inf)
        rises = sound & (t > np.concatenate(([-np.inf], np.maximum.accumulate(t)[:-1])))
        _tell(task, file, clock, sound & ~rises, Kind.BACK, data[clock])
        for key in (clock, *owned):
            data[key] = data[key][rises]
    sound = np.abs(data["imu_accel_t"]) < LATEST_S
    _tell(task, file, "imu_accel_t", ~sound, Kind.NOT_FINITE, data["imu_accel_t"])
    data["imu_accel_t"], data["imu_accel"] = data["imu_accel_t"][sound], data["imu_accel"][sound]


def _tell(task: Task, file: str, channel: str, found: NDArray[np.bool_], kind: Kind, values: Floats) -> None:
    which = np.flatnonzero(found)
    if len(which):
        cases = [(_row(int(i)), float(values[i])) for i in which[:5]]
        task.findings.note(kind, file, channel, cases, len(which), "left out")


def _row(number: int) -> str:
    return f"row {number}"


def _imu(
    task: Task, file: str, data: dict[str, Floats], times: Integers, name: str, gyro: str
) -> Iterator[Rows]:
    units = {"gyro": task.units.of("gyro", "rad/s"), "accel": task.units.of("accel", "m/s2")}
    series = topics.samples(name, file, _row, units)
    t = data["imu_accel_t"]
    rates = np.column_stack([np.interp(t, data["imu_gyro_t"], column) for column in data[gyro].T])
    table = np.column_stack(
        (rates * units["gyro"].factor, data["imu_accel"] * units["accel"].factor, np.full(len(t), np.nan))
    )
    return portions(series, times, table, np.arange(len(t)))


def _gnss(file: str, drive: Comma2k19, times: Integers) -> Iterator[Rows]:
    series = topics.epochs(file, _row)
    table = np.full((len(times), len(series.table.columns) - 1), np.nan)
    table[:, 0] = 1.0
    table[:, 1:3] = np.degrees(drive.gnss_position[:, :2])
    table[:, 3] = drive.gnss_position[:, 2]
    table[:, 4:7] = drive.gnss_velocity
    table[:, series.columns("latency_s")[0]] = drive.gnss_arrival_t - drive.gnss_valid_t
    return portions(series, times, table, np.arange(len(times)))


def _truth(file: str, drive: Comma2k19, times: Integers) -> Iterator[Rows]:
    relative = (times - times[0]).astype(np.float64)
    reference = PoseReference(relative, drive.pose_position, drive.pose_velocity, drive.pose_q_eb)
    true = reference.truth(times - times[0])
    table = np.column_stack(
        (
            *(np.degrees(true.latitude), np.degrees(true.longitude), true.height),
            true.v_ned,
            *(np.degrees(angle) for angle in (true.yaw, true.pitch, true.roll)),
        )
    )
    return portions(topics.truth(file, _row), times, table, np.arange(len(times)))


def _others(task: Task, file: str, data: dict[str, Floats], gps: object) -> list[Stream]:
    """Magnetometer, speeds and steering, where the example has them."""
    assert callable(gps)
    wheels = " ".join(f"wheel_{n}_mps" for n in range(1, 5))
    kinds = {
        "mag": topics.magnetic("imu", file, _row, {"mag": task.units.of("mag", "uT")}),
        "car_speed": topics.plain("/speed/car", "navtwin.Speed", topics.table((4, "speed_mps")), file, _row),
        "wheel_speed": topics.plain("/speed/wheels", "navtwin.Wheels", topics.table((4, wheels)), file, _row),
        "steering": topics.plain("/steering", "navtwin.Steering", topics.table((4, "angle_deg")), file, _row),
    }
    streams: list[Stream] = []
    for key, series in kinds.items():
        clock, values = data.get(f"{key}_t"), data.get(key)
        if clock is None or values is None or len(clock) != len(values) or clock.ndim != 1:
            task.findings.note(Kind.MISSING, file, key, text="not there, or without its times")
            continue
        values = values.reshape(len(clock), -1)
        if values.shape[1] != len(series.table.columns) - 1:
            task.findings.note(
                Kind.UNREADABLE, file, key, [("its shape", str(values.shape))], text="left out"
            )
            continue
        sound = np.abs(clock) < LATEST_S
        streams.append(portions(series, gps(clock[sound]), values[sound], np.flatnonzero(sound)))
    return streams
