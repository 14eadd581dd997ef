"""Allan curves recorded on a real BMI160 beside those of its preset, below the folder of recordings."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

import allantools
import numpy as np
from numpy.typing import NDArray

from host.record.errors import UserError
from host.sim.recording.locate import VARIABLE, recording_path
from host.sim.scenario.errors import ScenarioError
from host.simulate.proof.figure import Figure
from host.simulate.proof.noise import DEG, rest
from host.simulate.stream import Drive, Request

Floats = NDArray[np.float64]
RATE_HZ, LENGTH_S = 100, 18_000.0
TAUS_S = np.array([0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0])
"""Beyond, the real chip's temperature makes a ramp, and five hours of a simulated one tell little."""
BAND_PERCENT = 15.0
"""Within which the preset was fitted to the curves."""
UNITS = {"acc": 1.0, "gyr": DEG / 3600.0}


def figures() -> Iterator[Figure]:
    """Each axis: the largest difference of the curves."""
    drive = Drive(
        Request(
            rest(LENGTH_S, imu={"preset": "bmi160", "temperature": {"rise_k": 0.0}}),
            rate_hz=Fraction(RATE_HZ),
            gnss_rate_hz=Fraction(0),
        )
    )
    felt = np.vstack([block.felt for block in drive.blocks()])
    for k, (sensor, axis) in enumerate((sensor, axis) for sensor in UNITS for axis in "xyz"):
        real_tau, real = (_column(f"data_BMI160_{sensor}_{name}.txt") for name in ("t", axis))
        tau, ours, _, _ = allantools.oadev(felt[:, k], rate=float(RATE_HZ), data_type="freq", taus=TAUS_S)
        there = np.exp(np.interp(np.log(tau), np.log(real_tau), np.log(real * UNITS[sensor])))
        off = 100.0 * float(np.max(np.abs(ours / there - 1.0)))
        name = {"acc": "accelerometer", "gyr": "gyro"}[sensor]
        yield Figure("bmi160", f"{name} {axis}: largest difference", "%", off, "", most=BAND_PERCENT)


def _column(name: str) -> Floats:
    try:
        return np.loadtxt(recording_path(f"bmi160_allan/{name}", None))
    except (ScenarioError, OSError, ValueError):
        raise UserError(
            f"bmi160: needs bmi160_allan/{name}, a column of numbers, in the folder of recordings that"
            f" {VARIABLE} names, for example {VARIABLE}=~/recordings"
        ) from None
