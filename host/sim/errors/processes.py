"""Slow random processes as functions of time: Gauss–Markov and random walk at nodes, linear between them.

A node k lies at k · 2^shift ns. Nodes are drawn in the same chunks as the vehicle's position, each channel
from a generator of its own, and the latest chunks are kept: the memory stays flat, the sampling of a chip
changes nothing, and an instant far back comes out the same by running again from the start.

    x(k+1) = x(k) e^(−Δ/T) + σ √(1 − e^(−2Δ/T)) w   (Gauss–Markov, stationary from the start)
    x(k+1) = x(k) + q √Δ w                           (random walk from 0)

Source 002, eqs. 2-60 … 2-65 (with the x_k that 2-64 lacks after its exponential).
"""

from __future__ import annotations

import math
from collections import OrderedDict
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from host.sim.compiled import entry
from host.sim.seeding import generator
from host.sim.trajectory.motion import CHUNK_SHIFT, split_by_chunk

SLOWEST_SHIFT = 30
"""Nodes at most 1.07 s apart."""
NODES_PER_CORRELATION_TIME = 40.0
"""Closer nodes for short correlation times: linear interpolation then lacks 1 % of the variance."""


CHUNKS_KEPT = 64
"""36 minutes."""


@dataclass(frozen=True)
class Process:
    """One channel. `correlation_s` None: random walk, `sigma` per √s; else Gauss–Markov of that σ."""

    name: str
    sigma: float
    correlation_s: float | None = None


class ProcessBank:
    """Several processes on one grid of nodes."""

    def __init__(self, processes: list[Process], seed: int) -> None:
        self._processes = processes
        self._seed = seed
        self.node_shift = self._choose_shift()
        step = (1 << self.node_shift) * 1e-9
        self._decay = np.array(
            [math.exp(-step / p.correlation_s) if p.correlation_s else 1.0 for p in processes]
        )
        self._drive = np.array(
            [
                p.sigma
                * (
                    math.sqrt(-math.expm1(-2.0 * step / p.correlation_s))
                    if p.correlation_s
                    else math.sqrt(step)
                )
                for p in processes
            ]
        )
        self._chunks: OrderedDict[int, NDArray[np.float64]] = OrderedDict()
        self._rewind()

    def _choose_shift(self) -> int:
        times = [p.correlation_s for p in self._processes if p.correlation_s and p.sigma > 0.0]
        shift = SLOWEST_SHIFT
        while times and (1 << shift) * 1e-9 > min(times) / NODES_PER_CORRELATION_TIME:
            shift -= 1
        return shift

    def _rewind(self) -> None:
        """Back to the start of the run."""
        self._next_chunk = 0
        self._noise = [generator(self._seed, p.name) for p in self._processes]
        sigmas = [p.sigma if p.correlation_s else 0.0 for p in self._processes]
        self._state = np.array([s * g.standard_normal() for s, g in zip(sigmas, self._noise, strict=True)])

    def nodes(self, chunk: int) -> NDArray[np.float64]:
        """Nodes (n + 1, channels) of one chunk; the last is the first of the next."""
        nodes = self._chunks.get(chunk)
        if nodes is not None:
            return nodes
        if chunk < self._next_chunk:
            self._rewind()
        while self._next_chunk <= chunk:
            nodes = self._run()
        assert nodes is not None
        self._chunks[chunk] = nodes
        if len(self._chunks) > CHUNKS_KEPT:
            self._chunks.popitem(last=False)
        return nodes

    def values(self, times_ns: NDArray[np.int64]) -> NDArray[np.float64]:
        """All channels at rising times, (n, channels)."""
        out = np.empty((len(times_ns), len(self._processes)))
        for chunk, part in split_by_chunk(times_ns):
            elapsed_ns = times_ns[part] - (chunk << CHUNK_SHIFT)
            out[part] = between_nodes(self.nodes(chunk), self.node_shift, elapsed_ns)
        return out

    def _run(self) -> NDArray[np.float64]:
        """The next chunk."""
        count = 1 << (CHUNK_SHIFT - self.node_shift)
        nodes = np.empty((count + 1, len(self._processes)))
        nodes[0] = self._state
        for column, noise in enumerate(self._noise):
            if self._drive[column] != 0.0:
                draws = noise.standard_normal(count)
                run_process(self._decay[column], self._drive[column], draws, nodes, column)
            else:
                nodes[1:, column] = nodes[0, column]
        self._state = nodes[-1].copy()
        self._next_chunk += 1
        return nodes


def between_nodes(
    nodes: NDArray[np.float64], shift: int, elapsed_ns: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Linear between nodes (k, channels) 2^shift ns apart, at times since the first one; (n, channels)."""
    k = elapsed_ns >> shift
    x = (elapsed_ns - (k << shift)) / (1 << shift)
    values: NDArray[np.float64] = nodes[k] + x[:, None] * (nodes[k + 1] - nodes[k])
    return values


@entry
def run_process(
    decay: float, drive: float, noise: NDArray[np.float64], nodes: NDArray[np.float64], column: int
) -> None:
    """Continue one channel from its first node."""
    x = nodes[0, column]
    for k in range(noise.shape[0]):
        x = decay * x + drive * noise[k]
        nodes[k + 1, column] = x
