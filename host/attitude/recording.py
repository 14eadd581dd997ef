"""Recordings with a reference attitude: trials of the BROAD data set in all their layouts.

    .npz          imu_acc (n, 3) m/s², imu_gyr rad/s, imu_mag µT, opt_quat (n, 4), movement (n),
                  sampling_rate_hz
    .mat, .hdf5   the data set's own files: the same arrays, with sampling_rate (Hz)

The sensor's own axes. The reference turns them into east, north (magnetic), up, scalar first; NaN where the
cameras saw nothing. D. Laidig, M. Caruso, A. Cereatti, T. Seel: BROAD - A benchmark for robust inertial
orientation estimation. Data 6(7) 72 (2021), doi:10.3390/data6070072; CC BY 4.0.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from host.importers.numpy_archive import arrays_of, as_numbers
from host.record.errors import UserError

Floats = NDArray[np.float64]
Arrays = dict[str, Floats]

SENSORS = ("imu_acc", "imu_gyr", "imu_mag")
OTHERS = ("opt_quat", "movement")
RATES = ("sampling_rate_hz", "sampling_rate")
LEAST_SAMPLES = 100
SLOWEST_HZ, FASTEST_HZ = 1.0, 20_000.0
LARGEST_RATE, LARGEST_FORCE, LARGEST_FIELD_UT = 100.0, 2000.0, 5000.0


@dataclass(frozen=True, slots=True)
class AttitudeRecording:
    """Samples at even times, `rate_hz` of them a second, row k at k / rate_hz."""

    name: str
    rate_hz: float
    omega: Floats
    """(n, 3) rad/s."""
    force: Floats
    """(n, 3) m/s², specific force."""
    field: Floats
    """(n, 3) µT."""
    reference: Floats
    """(n, 4), sensor to east-north-up, scalar first, length 1 or NaN."""
    movement: NDArray[np.bool_]
    """(n,): where to score."""

    @property
    def interval(self) -> float:
        """s."""
        return 1.0 / self.rate_hz

    @property
    def times(self) -> Floats:
        """(n,) s."""
        return np.arange(len(self), dtype=np.float64) * self.interval

    def __len__(self) -> int:
        return len(self.omega)


def read_recording(path: Path) -> AttitudeRecording:
    """Raises UserError that names file, array and value."""
    if not path.is_file():
        raise UserError(f"{path}: no such file; for example broad/02_undisturbed_slow_rotation_B.npz")
    readers: dict[str, Callable[[Path], Arrays]] = {
        ".npz": _read_npz,
        ".mat": _read_mat,
        ".hdf5": _read_hdf5,
        ".h5": _read_hdf5,
    }
    reader = readers.get(path.suffix.lower())
    if reader is None:
        raise UserError(f"{path}: is none of {', '.join(readers)}; recordings are BROAD trials")
    return _checked(path, reader(path))


def _read_npz(path: Path) -> Arrays:
    return arrays_of(path, dict.fromkeys(SENSORS, 3), (*OTHERS, *RATES), "BROAD")


def _read_mat(path: Path) -> Arrays:
    _must_have("scipy", path)
    from scipy.io import loadmat

    try:
        content = loadmat(str(path))
    except NotImplementedError:  # version 7.3 is HDF5
        return {name: values.T for name, values in _read_hdf5(path).items()}
    except Exception as error:  # scipy raises many kinds for files that are none
        raise UserError(f"{path}: cannot be read as a MATLAB file: {_first_line(error)}") from None
    return _numbers(path, {name: content[name] for name in (*SENSORS, *OTHERS, *RATES) if name in content})


def _read_hdf5(path: Path) -> Arrays:
    _must_have("h5py", path)
    import h5py

    names = (*SENSORS, *OTHERS, *RATES)
    try:
        with h5py.File(path, "r") as file:
            found = {name: file[name][()] for name in names if isinstance(file.get(name), h5py.Dataset)}
            found |= {name: file.attrs[name] for name in RATES if name in file.attrs}
    except (OSError, KeyError, ValueError, RuntimeError, TypeError) as error:
        raise UserError(f"{path}: cannot be read as HDF5: {_first_line(error)}") from None
    return _numbers(path, found)


def _numbers(path: Path, found: dict[str, Any]) -> Arrays:
    try:
        return {name: as_numbers(values) for name, values in found.items()}
    except (TypeError, ValueError) as error:
        raise UserError(f"{path}: holds something else than numbers: {_first_line(error)}") from None


def _must_have(module: str, path: Path) -> None:
    if find_spec(module) is None:
        raise UserError(f"{path}: needs {module}, which is not installed: pip install {module}")


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]


def _checked(path: Path, data: Arrays) -> AttitudeRecording:
    missing = [name for name in (*SENSORS, *OTHERS) if name not in data]
    if missing:
        has = ", ".join(data) or "nothing of it"
        raise UserError(f"{path}: lacks {', '.join(missing)}; it has {has}. A BROAD trial has them")
    n = len(np.atleast_1d(data["imu_acc"]))
    for name, width in {**dict.fromkeys(SENSORS, 3), "opt_quat": 4}.items():
        if data[name].shape != (n, width):
            raise UserError(f"{path}: {name} has the shape {data[name].shape}; wanted: ({n}, {width})")
    if data["movement"].size != n:
        raise UserError(f"{path}: movement has {data['movement'].size} values for {n} samples")
    if n < LEAST_SAMPLES:
        raise UserError(f"{path}: holds {n} samples; {LEAST_SAMPLES} are the least")
    _check_magnitudes(path, data)
    movement = np.nan_to_num(data["movement"].reshape(-1)) > 0.5
    reference = _unit(data["opt_quat"])
    if not (movement & np.isfinite(reference).all(axis=1)).any():
        raise UserError(f"{path}: nothing to score: no sample with movement has a reference (opt_quat)")
    return AttitudeRecording(
        path.stem, _rate(path, data), data["imu_gyr"], data["imu_acc"], data["imu_mag"], reference, movement
    )


def _check_magnitudes(path: Path, data: Arrays) -> None:
    """Other units, most likely, when the middle of the values cannot be."""
    for name, unit, largest in (
        ("imu_gyr", "rad/s", LARGEST_RATE),
        ("imu_acc", "m/s²", LARGEST_FORCE),
        ("imu_mag", "µT", LARGEST_FIELD_UT),
    ):
        values = np.abs(data[name])
        if not np.isfinite(values).any():
            raise UserError(f"{path}: {name} holds no number at all")
        middle = float(np.nanmedian(values))
        if middle > largest:
            raise UserError(f"{path}: {name} is about {middle:.4g}; it must be in {unit}, below {largest:g}")
    force = float(np.nanmedian(np.linalg.norm(data["imu_acc"], axis=1)))
    if not 3.0 < force < 30.0:
        raise UserError(f"{path}: imu_acc is about {force:.4g} long; it must be in m/s², about 9.8 at rest")


def _unit(quaternions: Floats) -> Floats:
    length = np.linalg.norm(quaternions, axis=1, keepdims=True)
    return np.divide(
        quaternions, length, out=np.full_like(quaternions, np.nan), where=(length > 0.5) & (length < 2.0)
    )


def _rate(path: Path, data: Arrays) -> float:
    values = [float(data[name].reshape(-1)[0]) for name in RATES if name in data and data[name].size]
    if not values:
        raise UserError(f"{path}: lacks sampling_rate_hz (or sampling_rate), e.g. 285.714")
    if not SLOWEST_HZ <= values[0] <= FASTEST_HZ:
        raise UserError(
            f"{path}: sampling rate {values[0]:g} Hz; it must lie in {SLOWEST_HZ:g} … {FASTEST_HZ:g}, "
            "BROAD has 285.714"
        )
    return values[0]
