"""BROAD trials (D. Laidig et al., CC BY 4.0): hand-held nine-axis IMU with an optical reference.

The sensor's own axes are kept as x, y, z. The reference turns sensor axes into east, north, up, scalar first;
here it becomes sensor → north, east, down: q_ned = q · q_enu with the half turn q = (0, 1, 1, 0)/√2 that
exchanges north and east and turns up to down. It is NaN where the cameras did not see the body, and missing
there.
"""

from __future__ import annotations

import math

import numpy as np

from host.importers import topics
from host.importers.findings import Kind
from host.importers.numpy_archive import arrays_of
from host.importers.request import Recording, Task, only_file
from host.importers.series import Floats, Rows, portions
from host.importers.time_base import NS
from host.record.errors import UserError

SHAPES: dict[str, int | None] = {"imu_acc": 3, "imu_gyr": 3, "imu_mag": 3}
USUAL_RATE_HZ = 2000.0 / 7.0


def read_broad(task: Task) -> Recording:
    """IMU, magnetometer, reference, and when the body moves."""
    file = only_file(task, "02_undisturbed_slow_rotation_B.npz")
    data = arrays_of(file.path, SHAPES, ("opt_quat", "movement", "sampling_rate_hz"), "BROAD")
    n = len(data["imu_acc"])
    if len(data["imu_gyr"]) != n or len(data["imu_mag"]) != n:
        raise UserError(f"{file.path}: imu_acc, imu_gyr and imu_mag differ in length")
    rate = float(data.get("sampling_rate_hz", np.array(USUAL_RATE_HZ)).reshape(-1)[:1].sum())
    if not 0.0 < rate < 1e6:
        raise UserError(f"{file.path}: sampling_rate_hz = {rate:g} cannot be; BROAD has 285.71")
    times = np.rint(np.arange(n) / rate * NS).astype(np.int64)
    units = {"gyro": task.units.of("gyro", "rad/s"), "accel": task.units.of("accel", "m/s2")}
    field_unit = task.units.of("mag", "uT")
    samples = np.column_stack(
        (data["imu_gyr"] * units["gyro"].factor, data["imu_acc"] * units["accel"].factor, np.full(n, np.nan))
    )
    rows = np.arange(n)
    streams = [
        portions(topics.samples("imu", file.name, _row, units), times, samples, rows),
        portions(
            topics.magnetic("imu", file.name, _row, {"mag": field_unit}),
            times,
            data["imu_mag"] * field_unit.factor,
            rows,
        ),
    ]
    quaternions = data.get("opt_quat")
    if quaternions is None or quaternions.shape != (n, 4):
        task.findings.note(Kind.MISSING, file.name, "opt_quat", text="no reference")
    else:
        seen = np.isfinite(quaternions).all(axis=1) & (np.linalg.norm(quaternions, axis=1) > 0.5)
        if not seen.all():
            count = int((~seen).sum())
            task.findings.note(
                Kind.MISSING,
                file.name,
                "opt_quat",
                [(_row(int(np.argmin(seen))), "")],
                count,
                "not seen; left out",
            )
        attitude = _north_east_down(quaternions[seen])
        series = topics.attitude(file.name, _row, is_paced=False)
        streams.append(portions(series, times[seen], attitude, rows[seen]))
    moves = data.get("movement")
    if moves is not None and moves.shape == (n,):
        changed = np.flatnonzero(np.diff(moves, prepend=np.nan) != 0.0)
        table = topics.table((0, "moving"))
        series = topics.plain("/movement", "navtwin.Movement", table, file.name, _row, is_paced=False)
        streams.append(iter([Rows(series, times[changed], moves[changed, None], changed)]))
    task.meter(file.path.stat().st_size)
    return Recording(list(streams), is_absolute=False, facts={"sampling_rate_hz": rate})


def _row(number: int) -> str:
    return f"row {number}"


def _north_east_down(q_enu: Floats) -> Floats:
    """Rows of /attitude: yaw, pitch, roll in °, and the quaternion sensor → north, east, down."""
    w, x, y, z = (q_enu / np.linalg.norm(q_enu, axis=1, keepdims=True)).T
    half = math.sqrt(0.5)
    q = np.column_stack((-half * (x + y), half * (w + z), half * (w - z), half * (y - x)))
    q *= np.where(q[:, :1] < 0.0, -1.0, 1.0)
    w, x, y, z = q.T
    yaw = np.arctan2(2.0 * (x * y + w * z), 1.0 - 2.0 * (y * y + z * z)) % (2.0 * math.pi)
    pitch = np.arcsin(np.clip(2.0 * (w * y - x * z), -1.0, 1.0))
    roll = np.arctan2(2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y))
    return np.column_stack((np.degrees(yaw), np.degrees(pitch), np.degrees(roll), q))
