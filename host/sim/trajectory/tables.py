"""The compiled form of a motion: plain arrays that the kinematics kernel reads."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from host.sim.trajectory.disturbance import Disturbance
from host.sim.trajectory.segments import CHANNELS, ChannelPieces

FIRST, LIMITS, STARTS = 0, 5, 12
"""Where in `layout` stand: first row of each channel's pieces and the end (5), limits of the bank's targets
(7), start times of the pieces in ns."""

HALF_SPEED_SQUARED, SHAKE_ALWAYS, CONE_ANGLE, CONE_FREQUENCY = range(4)


class MotionTables(NamedTuple):
    """The four arrays of a motion.

    Kernels take them one by one: reaching into a tuple would count references in every step of their loops.
    """

    layout: NDArray[np.int64]
    coefficients: NDArray[np.float64]
    """(pieces, 21) rows of `Piece.coefficients`, channel after channel."""
    bank: NDArray[np.float64]
    """(5, n) frequency in Hz, phase in turns, amplitude in rad or m, amplitude · ω, amplitude · ω²."""
    constants: NDArray[np.float64]


def compile_tables(channels: dict[str, ChannelPieces], disturbance: Disturbance) -> MotionTables:
    """Lay the pieces and sinusoids out for the kernels."""
    counts = [len(channels[name].pieces) for name in CHANNELS]
    starts = [start for name in CHANNELS for start in channels[name].starts_ns]
    rows = [piece.coefficients() for name in CHANNELS for piece in channels[name].pieces]
    bank, limits = disturbance.bank()
    constants = np.zeros(4)
    constants[HALF_SPEED_SQUARED] = disturbance.half_speed_mps**2
    constants[SHAKE_ALWAYS] = float(disturbance.always)
    constants[CONE_ANGLE] = disturbance.coning.half_angle
    constants[CONE_FREQUENCY] = disturbance.coning.frequency_hz
    return MotionTables(
        np.concatenate(([0], np.cumsum(counts), limits, starts)).astype(np.int64),
        np.array(rows, dtype=np.float64),
        bank,
        constants,
    )
