"""Inertial samples of a file, for Allan curves: NPZ, CSV and text as `navtwin simulate` writes them."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from host.record.errors import UserError
from host.simulate.allan import Record

Floats = NDArray[np.float64]

GYRO, ACCEL = tuple(f"gyro_{axis}" for axis in "xyz"), tuple(f"accel_{axis}" for axis in "xyz")
NAMES = {
    **{f"rate_{axis}_radps": (f"gyro_{axis}", False) for axis in "xyz"},
    **{f"force_{axis}_mps2": (f"accel_{axis}", False) for axis in "xyz"},
    **{f"dtheta_{axis}_rad": (f"gyro_{axis}", True) for axis in "xyz"},
    **{f"dv_{axis}_mps": (f"accel_{axis}", True) for axis in "xyz"},
    **{f"gyro_{axis}": (f"gyro_{axis}", False) for axis in "xyz"},
    **{f"accel_{axis}": (f"accel_{axis}", False) for axis in "xyz"},
}
"""Columns of a CSV: the channel, and whether it holds increments."""
TIMES = ("t_s", "time")
LEAST_SAMPLES = 1000
UNEVEN = 0.01
"""Intervals may differ by so much of themselves."""


def read_record(path: Path) -> Record:
    """Raises UserError that names file, line and value."""
    if not path.is_file():
        raise UserError(f"{path}: no such file; for example navtwin simulate static -o rest.npz")
    readers = {".npz": _read_npz, ".csv": _read_csv, ".txt": _read_kf_gins}
    if path.suffix not in readers:
        raise UserError(f"{path}: is none of {', '.join(readers)}, as navtwin simulate writes them")
    try:
        t, channels, increments = readers[path.suffix](path)
    except (OSError, UnicodeDecodeError) as error:
        raise UserError(f"{path}: cannot be read: {error}") from None
    return _checked(path, t, channels, increments)


def _checked(path: Path, t: Floats, channels: dict[str, Floats], increments: bool) -> Record:
    if len(t) < LEAST_SAMPLES:
        raise UserError(f"{path}: holds {len(t)} samples; an Allan curve needs {LEAST_SAMPLES} at least")
    for name, values in {"time": t, **channels}.items():
        bad = np.flatnonzero(~np.isfinite(values))
        if len(bad):
            raise UserError(f"{path}: sample {bad[0] + 1}: {name} is not a number")
    steps = np.diff(t)
    usual = float(np.median(steps))
    if usual <= 0.0:
        raise UserError(f"{path}: time does not rise")
    odd = np.flatnonzero(np.abs(steps - usual) > UNEVEN * usual)
    if len(odd):
        k = int(odd[0])
        raise UserError(
            f"{path}: sample {k + 2}: {steps[k]:g} s after the one before, the others {usual:g} s; an Allan"
            " curve needs even intervals: cut the file there"
        )
    rate = (len(t) - 1) / float(t[-1] - t[0])
    if increments:
        channels = {name: values * rate for name, values in channels.items()}
    return Record(rate, channels, path)


def _read_npz(path: Path) -> tuple[Floats, dict[str, Floats], bool]:
    try:
        with np.load(path) as archive:
            imu = archive["imu"]
            increments = "dtheta" in (imu.dtype.names or ())
            rate, force = ("dtheta", "dv") if increments else ("rate", "force")
            table = np.hstack((imu[rate], imu[force]))
            t = imu["t_ns"] / 1e9
    except (ValueError, KeyError, IndexError, zipfile.BadZipFile) as error:
        raise UserError(f"{path}: is not what navtwin simulate writes as NPZ: {error}") from None
    return t, dict(zip((*GYRO, *ACCEL), table.T, strict=True)), increments


def _read_csv(path: Path) -> tuple[Floats, dict[str, Floats], bool]:
    with path.open(encoding="utf-8-sig") as file:
        header = [name.strip() for name in file.readline().split(",")]
    time = next((header.index(name) for name in TIMES if name in header), None)
    places = {name: header.index(name) for name in NAMES if name in header}
    if time is None or not places:
        raise UserError(
            f"{path}: line 1: needs a column t_s or time, and some of rate_x_radps, force_x_mps2, gyro_x,"
            " accel_x …"
        )
    try:
        table = np.loadtxt(path, delimiter=",", skiprows=1, usecols=[time, *places.values()], ndmin=2)
    except (ValueError, IndexError) as error:
        raise UserError(f"{path}: {error}") from None
    channels = {NAMES[name][0]: table[:, k] for k, name in enumerate(places, start=1)}
    return table[:, 0], channels, NAMES[next(iter(places))][1]


def _read_kf_gins(path: Path) -> tuple[Floats, dict[str, Floats], bool]:
    try:
        table = np.loadtxt(path, ndmin=2)
    except ValueError as error:
        raise UserError(f"{path}: {error}") from None
    if table.shape[1] != 7:
        raise UserError(f"{path}: has {table.shape[1]} columns; inertial samples of KF-GINS have 7")
    return table[:, 0], dict(zip((*GYRO, *ACCEL), table[:, 1:].T, strict=True)), True
