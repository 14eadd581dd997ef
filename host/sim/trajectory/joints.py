"""Where a path is not smooth: steps of its channels and their rates at joints, and its largest jerk.

The numeric form of the document steps acceleration and turn rate by definition; these steps are told. Speed
and angles never step by more than the rounding of joints to whole nanoseconds leaves.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from host.sim.trajectory.piece import Piece
from host.sim.trajectory.segments import ChannelPieces

NS = 1_000_000_000
RATE_OF = {"speed": "acceleration", "yaw": "turn rate", "pitch": "pitch rate", "roll": "roll rate"}
UNIT_OF = {"speed": "m/s²", "yaw": "rad/s", "pitch": "rad/s", "roll": "rad/s"}
LEAST = 1e-7
"""Steps below are rounding: a nanosecond at 100 m/s³."""
LOOKS = 64
"""Instants of each piece at which jerk is looked at."""


@dataclass(frozen=True, slots=True)
class Step:
    """A rate that steps."""

    at_s: float
    what: str
    size: float
    unit: str


@dataclass(frozen=True, slots=True)
class Joints:
    """Of a whole path."""

    steps: tuple[Step, ...]
    largest_value_step: float
    """Of speed (m/s) or an angle (rad)."""
    largest_jerk_mps3: float
    """Along the path, between joints; turning apart."""


def examine(channels: Mapping[str, ChannelPieces]) -> Joints:
    """Look at all joints."""
    steps, values = [], [0.0]
    for name, channel in channels.items():
        slopes = [piece.derivative() for piece in channel.pieces]
        for k in range(1, len(slopes)):
            before, after = channel.pieces[k - 1], channel.pieces[k]
            length_s = (channel.starts_ns[k] - channel.starts_ns[k - 1]) / NS
            values.append(abs(after.value(0.0) - before.value(length_s)))
            size = slopes[k].value(0.0) - slopes[k - 1].value(length_s)
            if abs(size) > LEAST:
                steps.append(Step(channel.starts_ns[k] / NS, RATE_OF[name], size, UNIT_OF[name]))
    steps.sort(key=lambda step: step.at_s)
    return Joints(tuple(steps), max(values), _largest_jerk(channels["speed"].pieces))


def _largest_jerk(pieces: list[Piece]) -> float:
    largest = 0.0
    for piece in pieces:
        jerk = piece.derivative().derivative()
        largest = max(largest, *(abs(jerk.value(piece.duration_s * k / LOOKS)) for k in range(LOOKS + 1)))
    return largest
