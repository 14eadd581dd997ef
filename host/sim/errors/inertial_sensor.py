"""One inertial sensor on the simulated vehicle: what its chip model samples."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from host.sim.errors.drawn import AXES, Specimen
from host.sim.errors.processes import ProcessBank, between_nodes
from host.sim.errors.sensor_kernel import (
    BIAS_A,
    BIAS_G,
    CROSS_A,
    CROSS_G,
    DENSITY,
    G_SENSITIVITY,
    LEVER,
    MOUNTING,
    NOISE_MEMORY,
    SCALE_A,
    SCALE_G,
    SLOW,
    SQUARE_A,
    SQUARE_G,
    TEMPERATURE,
    sense,
)
from host.sim.errors.sensor_kernel import CONSTANTS as SENSOR_CONSTANTS
from host.sim.seeding import generator
from host.sim.trajectory.motion import CHUNK_SHIFT, CHUNKS_KEPT, split_by_chunk

Array = NDArray[np.float64]


class Course(Protocol):
    """A motion."""

    def rows(self, times_ns: NDArray[np.int64]) -> Array:
        """Rows of truth (n, 24) at rising times; columns as in `host.sim.trajectory.kinematics`."""
        ...


class InertialSensor:
    """A gyro and accelerometer triad. Implements `boards.chips.world.ImuWorld`."""

    def __init__(
        self,
        motion: Course | None,
        specimen: Specimen,
        seed: int,
        component: str,
        mounting: Array,
        lever_arm: Array,
    ) -> None:
        """`mounting` = C_b_s (3, 3): body = C_b_s sensor; `lever_arm` (3,) from the origin, body axes, m.

        Without a motion it measures only what it is given.
        """
        self._motion = motion
        self.specimen = specimen
        self._bank = ProcessBank([*specimen.gyro.processes, *specimen.accelerometer.processes], seed)
        self._constants = _pack(specimen, mounting, lever_arm)
        self._memory = np.zeros(NOISE_MEMORY)
        self._memory[-1] = -1.0
        channels = [
            f"{component}.{triad}_{axis}.noise" for triad in ("gyro", "accelerometer") for axis in AXES
        ]
        densities = self._constants[DENSITY : DENSITY + 6].tolist()
        self._noise = [
            generator(seed, name) if density else None
            for name, density in zip(channels, densities, strict=True)
        ]
        """Of the channels that have noise."""
        self._slow: dict[int, Array] = {}
        self._output_changes = specimen.output.changes

    def put_on(self, motion: Course) -> None:
        """Let it go through another motion."""
        self._motion = motion

    def road(self, times_ns: NDArray[np.int64]) -> Array:
        """Rows of truth (n, 24) at rising times, as `measured` takes them."""
        assert self._motion is not None
        return self._motion.rows(times_ns)

    def sample(self, times_ns: NDArray[np.int64], bandwidth_hz: float) -> Array:
        """Force (3), rate (3), temperature at rising times; see `boards.chips.world.ImuWorld.sample`."""
        assert self._motion is not None
        times_ns = np.ascontiguousarray(times_ns, dtype=np.int64)
        return self.measured(times_ns, self._motion.rows(times_ns), bandwidth_hz)

    def measured(self, times_ns: NDArray[np.int64], rows: Array, bandwidth_hz: float) -> Array:
        """What `sample` gives at instants whose rows of truth (n, 24) the caller has already; the forces and
        rates in them may be means over the time since the instant before."""
        out = np.empty((len(times_ns), 7))
        normals = np.zeros((6, len(times_ns)))
        for channel, row in zip(self._noise, normals, strict=True):
            if channel is not None:
                channel.standard_normal(out=row)
        for chunk, part in split_by_chunk(times_ns):
            sense(
                rows[part],
                self._slow_nodes(chunk),
                chunk << CHUNK_SHIFT,
                self._bank.node_shift,
                self._constants,
                bandwidth_hz,
                normals,
                part.start,
                self._memory,
                times_ns[part],
                out[part],
            )
        if self._output_changes:
            self.specimen.output.passed(times_ns, out)
        return out

    def slow_errors(self, times_ns: NDArray[np.int64]) -> Array:
        """Bias of gyro (3, rad/s) and accelerometer (3, m/s²), their scale errors (3, 3) and the temperature,
        shape (n, 13), in the sensor's axes, at rising times."""
        out = np.empty((len(times_ns), SLOW))
        for chunk, part in split_by_chunk(times_ns):
            elapsed_ns = times_ns[part] - (chunk << CHUNK_SHIFT)
            out[part] = between_nodes(self._slow_nodes(chunk), self._bank.node_shift, elapsed_ns)
        return out

    def _slow_nodes(self, chunk: int) -> Array:
        nodes = self._slow.get(chunk)
        if nodes is None:
            nodes = self._compose(chunk)
            self._slow[chunk] = nodes
            if len(self._slow) > CHUNKS_KEPT:
                del self._slow[next(iter(self._slow))]
        return nodes

    def _compose(self, chunk: int) -> Array:
        """Sum fixed, drawn, running and temperature parts at the nodes of a chunk."""
        running = self._bank.nodes(chunk)
        s = self.specimen
        out = np.empty((len(running), SLOW))
        t = ((chunk << CHUNK_SHIFT) + np.arange(len(running)) * (1 << self._bank.node_shift)) * 1e-9
        warm = np.array([-math.expm1(-x / s.rise_time_s) for x in t.tolist()])
        out[:, TEMPERATURE] = s.start_c + s.rise_k * warm
        above = out[:, TEMPERATURE : TEMPERATURE + 1] - s.reference_c
        for triad, first, bias, scale in (
            (s.gyro, 0, BIAS_G, SCALE_G),
            (s.accelerometer, 9, BIAS_A, SCALE_A),
        ):
            instability, walk, scale_drift = (running[:, k : k + 3] for k in (first, first + 3, first + 6))
            out[:, bias : bias + 3] = triad.bias + (instability + walk) + triad.bias_per_kelvin * above
            out[:, scale : scale + 3] = triad.scale + scale_drift + triad.scale_per_kelvin * above
        return out


def _pack(specimen: Specimen, mounting: Array, lever_arm: Array) -> Array:
    """The sensor's constants in the layout of `sensor_kernel`."""
    constants = np.empty(SENSOR_CONSTANTS)
    constants[LEVER:MOUNTING] = lever_arm
    constants[MOUNTING:CROSS_G] = np.asarray(mounting, dtype=np.float64).reshape(9)
    constants[CROSS_G:CROSS_A] = specimen.gyro.cross.reshape(9)
    constants[CROSS_A:G_SENSITIVITY] = specimen.accelerometer.cross.reshape(9)
    constants[G_SENSITIVITY:DENSITY] = specimen.g_sensitivity.reshape(9)
    constants[DENSITY : DENSITY + 3] = specimen.gyro.noise_density
    constants[DENSITY + 3 : SQUARE_G] = specimen.accelerometer.noise_density
    constants[SQUARE_G:SQUARE_A] = specimen.gyro.quadratic
    constants[SQUARE_A:] = specimen.accelerometer.quadratic
    return constants
