"""Inertial increments that belong to a trajectory, and the reference that belongs to them.

Inverse mechanization in a closed loop (`host.sim.mechanization`): each interval is inverted from the forward
result of the one before, so that the difference to the wanted motion does not grow. What is written as
reference is that forward result; the closure is that of a second forward mechanization, of the increments
alone.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from host.sim.mechanization import (
    BENT,
    GAINED,
    HEIGHT,
    LATITUDE,
    PUSHED,
    QUATERNION,
    STATE,
    TURNED,
    VELOCITY,
    integrate,
    invert,
)
from host.sim.trajectory.kinematics import C_NB, FORCE, OMEGA_IB, ROW
from host.simulate.attitude_forms import matrices, product
from host.simulate.body_point import point_states
from host.simulate.epochs import EpochFeed
from host.simulate.flyable import Flyable
from host.simulate.formats.known import Format
from host.simulate.instants import NS, count_within, instants
from host.simulate.part_files import PartFiles
from host.simulate.rows import gnss_rows
from host.simulate.sensors import TrackSensors
from host.simulate.source import SideTable
from host.simulate.stream import BLOCK, Block, Convention

Floats = NDArray[np.float64]
Progress = Callable[[float, float], None]

EARTH_RADIUS = 6.371e6


@dataclass(frozen=True)
class Inverse:
    """Increments along a motion: a source of blocks for the writers."""

    motion: Flyable
    rate_hz: Fraction
    convention: Convention
    start_gps_ns: int
    sensors: TrackSensors
    gnss_rate_hz: Fraction = Fraction(0)
    """0: no receiver."""
    side_tables: tuple[SideTable, ...] = ()

    @property
    def epochs(self) -> int:
        """How many of the receiver."""
        return count_within(self.gnss_rate_hz, self.duration_ns) + 1 if self.gnss_rate_hz else 0

    @property
    def duration_ns(self) -> int:
        """Of the whole intervals."""
        return int(instants(self.rate_hz, self.samples, 1)[0])

    @property
    def samples(self) -> int:
        """Whole intervals in the motion."""
        return count_within(self.rate_hz, round(self.motion.end_s * NS))

    def blocks(self, closure: Closure) -> Iterator[Block]:
        """All intervals, in order; `closure` learns how well they close."""
        start = self._beginning()
        loop, alone = start.copy(), start.copy()
        for first in range(0, self.samples, BLOCK):
            count = min(BLOCK, self.samples - first)
            times_ns = instants(self.rate_hz, first, count + 1)
            lengths = np.diff(times_ns) / NS
            wanted = self._wanted(times_ns[1:] / NS)
            increments, states = np.empty((count, 6)), np.empty((count, STATE))
            invert(loop, wanted, lengths, increments, states)
            loop = states[-1].copy()
            forward = np.empty((count, STATE))
            integrate(alone, increments, lengths, forward)
            alone = forward[-1].copy()
            closure.add(forward, wanted)
            yield self._block(
                times_ns[1:], lengths, increments, self._of_origin(times_ns[1:], states, wanted)
            )

    def _wanted(self, t_s: Floats) -> Floats:
        """What the sensor's place is to do (n, 10): position, velocity, quaternion."""
        return point_states(self.motion, t_s, np.array(self.sensors.places.sensor_m))

    def _of_origin(self, times_ns: NDArray[np.int64], states: Floats, wanted: Floats) -> Floats:
        """The origin's states that belong to those of the sensor's place: as far from what was wanted."""
        if not any(self.sensors.places.sensor_m):
            return states
        here = self.motion.states(times_ns / NS)
        moved = states.copy()
        moved[:, :QUATERNION] += here[:, :QUATERNION] - wanted[:, :QUATERNION]
        back = wanted[:, QUATERNION:] * [1.0, -1.0, -1.0, -1.0]
        turned = product(states[:, QUATERNION:TURNED], product(back, here[:, QUATERNION:]))
        moved[:, QUATERNION:TURNED] = turned
        return moved

    def _beginning(self) -> Floats:
        """The state at time 0, with what the interval before it would have been at the same rates."""
        step = float(1 / self.rate_hz)
        wanted = self._wanted(np.array([0.0, step]))
        state = np.zeros(STATE)
        state[:TURNED] = wanted[0]
        state[GAINED:BENT] = wanted[1, VELOCITY:QUATERNION] - wanted[0, VELOCITY:QUATERNION]
        increments, after = np.empty((1, 6)), np.empty((1, STATE))
        for _ in range(3):
            invert(state, wanted[1:], np.array([step]), increments, after)
            state[TURNED:GAINED] = increments[0]
        assert TURNED < PUSHED < GAINED
        return state

    def _block(
        self, times_ns: NDArray[np.int64], lengths: Floats, increments: Floats, states: Floats
    ) -> Block:
        rows = np.zeros((len(times_ns), ROW))
        rows[:, LATITUDE : HEIGHT + 1] = states[:, LATITUDE : HEIGHT + 1]
        rows[:, VELOCITY:QUATERNION] = states[:, VELOCITY:QUATERNION]
        rows[:, C_NB:OMEGA_IB] = matrices(states[:, QUATERNION:TURNED])
        means = increments / lengths[:, None]
        rows[:, OMEGA_IB:FORCE], rows[:, FORCE : FORCE + 3] = means[:, :3], means[:, 3:]
        felt = self.sensors.felt(times_ns, rows, self.rate_hz)
        if self.convention is Convention.INCREMENT:
            felt[:, :6] *= lengths[:, None]
            rows[:, OMEGA_IB:FORCE], rows[:, FORCE : FORCE + 3] = increments[:, :3], increments[:, 3:]
        return Block(times_ns, felt, rows)


@dataclass
class Closure:
    """How far the forward mechanization of the increments alone ends from the wanted motion."""

    count: int = 0
    squares: Floats = field(default_factory=lambda: np.zeros(3))
    largest: Floats = field(default_factory=lambda: np.zeros(3))

    def add(self, forward: Floats, wanted: Floats) -> None:
        """More states beside what was wanted."""
        difference = forward[:, :QUATERNION] - wanted[:, :QUATERNION]
        difference[:, 0] *= EARTH_RADIUS
        difference[:, 1] *= EARTH_RADIUS * np.cos(wanted[:, LATITUDE])
        sizes = np.column_stack(
            (
                np.linalg.norm(difference[:, :VELOCITY], axis=1),
                np.linalg.norm(difference[:, VELOCITY:], axis=1),
                np.degrees(_angles_between(forward[:, QUATERNION:TURNED], wanted[:, QUATERNION:TURNED])),
            )
        )
        self.count += len(sizes)
        self.squares += (sizes**2).sum(axis=0)
        self.largest = np.maximum(self.largest, sizes.max(axis=0))

    def figures(self) -> dict[str, float]:
        """RMS and largest: position m, velocity m/s, attitude °."""
        rms = np.sqrt(self.squares / max(self.count, 1))
        names = ("position_{}_m", "velocity_{}_mps", "attitude_{}_deg")
        found = {name.format("rms"): float(value) for name, value in zip(names, rms, strict=True)}
        return found | {n.format("max"): float(v) for n, v in zip(names, self.largest, strict=True)}


@dataclass(frozen=True, slots=True)
class Inverted:
    """What came of it."""

    closure: Closure
    wall_s: float
    files: tuple[Path, ...]
    fastest_mps: float
    strongest_mps2: float
    """Largest specific force."""


def invert_track(
    inverse: Inverse,
    path: Path | None,
    form: Format | None,
    about: Mapping[str, Any],
    progress: Progress | None,
    read: Path | None = None,
) -> Inverted:
    """Invert, and write when there is a path, but not over what was `read`. Raises UserError."""
    begin = time.perf_counter()
    closure = Closure()
    fastest = strongest = 0.0
    with PartFiles(read) as files:
        writer = None if path is None or form is None else form.writer(inverse, path, files, about)
        epochs = EpochFeed(inverse.sensors.epochs(inverse.gnss_rate_hz, inverse.duration_ns))
        for block in inverse.blocks(closure):
            speeds = np.linalg.norm(block.truth[:, VELOCITY:QUATERNION], axis=1)
            forces = np.linalg.norm(block.truth[:, FORCE : FORCE + 3], axis=1)
            if inverse.convention is Convention.INCREMENT:
                forces = forces * float(inverse.rate_hz)
            fastest, strongest = max(fastest, float(speeds.max())), max(strongest, float(forces.max()))
            if writer is not None:
                writer.add_block(block)
                due = epochs.until(int(block.times_ns[-1]))
                if due:
                    writer.add_gnss(gnss_rows(due))
            if progress is not None:
                progress(float(block.times_ns[-1]) / NS, inverse.duration_ns / NS)
        if writer is not None:
            writer.finish()
    return Inverted(closure, time.perf_counter() - begin, tuple(files.paths), fastest, strongest)


def _angles_between(one: Floats, other: Floats) -> Floats:
    """Angles between attitudes, rad: 2 |vector part| of one⁻¹ ⊗ other, which are small."""
    a, v = one[:, :1], -one[:, 1:]
    w, u = other[:, :1], other[:, 1:]
    vector = a * u + w * v + np.cross(v, u)
    angles: Floats = 2.0 * np.arcsin(np.minimum(1.0, np.linalg.norm(vector, axis=1)))
    return angles
