"""The compiled form of a motion: plain arrays that the kinematics kernel reads."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from host.sim.trajectory.disturbance import Disturbance
from host.sim.trajectory.segments import CHANNELS, ChannelPieces

HALF_SPEED_SQUARED, SHAKE_ALWAYS, CONE_ANGLE, CONE_FREQUENCY = range(4)


class MotionTables(NamedTuple):
    """Pieces of the four channels one after the other, the bank of sinusoids, constants."""

    first: NDArray[np.int64]
    """(5,) row at which each channel's pieces begin, and the end."""
    start_ns: NDArray[np.int64]
    coefficients: NDArray[np.float64]
    """(pieces, 21) rows of `Piece.coefficients`."""
    bank: NDArray[np.float64]
    """(3, n) frequency in Hz, phase in turns, amplitude in rad or m/s."""
    bank_limits: NDArray[np.int64]
    constants: NDArray[np.float64]


def compile_tables(channels: dict[str, ChannelPieces], disturbance: Disturbance) -> MotionTables:
    """Lay the pieces and sinusoids out for the kernel."""
    counts = [len(channels[name].pieces) for name in CHANNELS]
    starts = [start for name in CHANNELS for start in channels[name].starts_ns]
    rows = [piece.coefficients() for name in CHANNELS for piece in channels[name].pieces]
    bank, limits = disturbance.bank()
    constants = np.zeros(4)
    constants[HALF_SPEED_SQUARED] = disturbance.half_speed_mps**2
    constants[SHAKE_ALWAYS] = float(disturbance.always)
    constants[CONE_ANGLE] = disturbance.coning.half_angle
    constants[CONE_FREQUENCY] = disturbance.coning.frequency_hz
    if not all(math.isfinite(x) for row in rows for x in row):
        raise ValueError("the trajectory's pieces hold numbers that are not finite")
    return MotionTables(
        np.concatenate(([0], np.cumsum(counts))).astype(np.int64),
        np.array(starts, dtype=np.int64),
        np.array(rows, dtype=np.float64),
        bank,
        limits,
        constants,
    )
