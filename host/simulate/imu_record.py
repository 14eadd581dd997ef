"""Inertial samples of a file, for Allan curves: NPZ, CSV and text as `navtwin simulate` writes them."""

from __future__ import annotations

import warnings
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
LARGEST = 1e6
"""Of any value: no gyro and no accelerometer measures so much."""
UNEVEN = 0.01
"""Intervals may differ by so much of themselves."""


def read_record(path: Path) -> Record:
    """Raises UserError that names file, line and value."""
    if not path.is_file():
        raise UserError(f"{path}: no such file; for example navtwin simulate static -o rest.npz")
    readers = {".npz": _read_npz, ".csv": _read_csv, ".txt": _read_kf_gins}
    if path.suffix.lower() not in readers:
        raise UserError(f"{path}: is none of {', '.join(readers)}, as navtwin simulate writes them")
    try:
        t, channels, increments = readers[path.suffix.lower()](path)
    except (OSError, UnicodeDecodeError) as error:
        raise UserError(f"{path}: cannot be read: {error}") from None
    return _checked(path, t, channels, increments)


def _checked(path: Path, t: Floats, channels: dict[str, Floats], increments: bool) -> Record:
    if len(t) < LEAST_SAMPLES:
        raise UserError(f"{path}: holds {len(t)} samples; an Allan curve needs {LEAST_SAMPLES} at least")
    for name, values in {"time": t, **channels}.items():
        bad = np.flatnonzero(~np.isfinite(values))
        if len(bad):
            raise UserError(
                f"{path}: sample {bad[0] + 1}: {name} is {values[bad[0]]:g}, no finite number; cut the file"
                " there"
            )
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
    for name, values in channels.items():
        largest = int(np.argmax(np.abs(values)))
        if abs(values[largest]) > LARGEST:
            raise UserError(
                f"{path}: sample {largest + 1}: {name} is {values[largest]:g}; at most {LARGEST:g} (SI units)"
            )
        if np.ptp(values) == 0.0:
            raise UserError(
                f"{path}: {name} is {values[0]:g} in all samples: without noise there is nothing to be found;"
                " leave that column out, or simulate with errors, e.g. --set imu.preset=stim300"
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
            triads = [np.asarray(imu[name], dtype=np.float64).reshape(len(imu), 3) for name in (rate, force)]
            table = np.hstack(triads)
            t = np.asarray(imu["t_ns"], dtype=np.int64) / 1e9
    except (EOFError, TypeError, ValueError, KeyError, IndexError, zipfile.BadZipFile) as error:
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
    for name in (TIMES[0], TIMES[1], *places):
        if header.count(name) > 1:
            raise UserError(f"{path}: line 1: column {name} is there twice; keep one")
    if len({NAMES[name][1] for name in places}) > 1:
        told = ", ".join(places)
        raise UserError(f"{path}: line 1: rates and increments ({told}); keep one kind")
    table = _numbers(path, [time, *places.values()], ",", 1)
    channels = {NAMES[name][0]: table[:, k] for k, name in enumerate(places, start=1)}
    return table[:, 0], channels, NAMES[next(iter(places))][1]


def _read_kf_gins(path: Path) -> tuple[Floats, dict[str, Floats], bool]:
    with path.open(encoding="utf-8") as file:
        count = len(file.readline().split())
    if count != 7:
        raise UserError(
            f"{path}: line 1: has {count} columns; inertial samples of KF-GINS have 7: second of the week,"
            " three of Δθ (rad), three of Δv (m/s)"
        )
    table = _numbers(path, list(range(7)), None, 0)
    return table[:, 0], dict(zip((*GYRO, *ACCEL), table[:, 1:].T, strict=True)), True


def _numbers(path: Path, columns: list[int], delimiter: str | None, skip: int) -> Floats:
    """Columns of a text. Raises UserError that names the line."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # no rows: told by how many there are
            table = np.loadtxt(path, delimiter=delimiter, skiprows=skip, usecols=columns, ndmin=2)
    except (ValueError, IndexError) as error:
        raise UserError(f"{path}: {_first_wrong(path, columns, delimiter, skip) or error}") from None
    return table.reshape(-1, len(columns))


def _first_wrong(path: Path, columns: list[int], delimiter: str | None, skip: int) -> str:
    """What is wrong in which line; empty where that cannot be told."""
    with path.open(encoding="utf-8-sig") as file:
        for number, line in enumerate(file, start=1):
            cells = line.strip().split(delimiter)
            if number <= skip or cells in ([], [""]):
                continue
            if len(cells) <= max(columns):
                return f"line {number}: {len(cells)} values; column {max(columns) + 1} is read"
            for column in columns:
                try:
                    float(cells[column])
                except ValueError:
                    return f"line {number}: {cells[column].strip()!r} is not a number; for example 0.0123"
    return ""
