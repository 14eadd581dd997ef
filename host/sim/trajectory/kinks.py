"""Position in those steps between nodes in which the path's acceleration or turn rate steps.

Neither the collocation nor the cubic of `host.sim.trajectory.nodes` sees such a joint: they pass one of
3 m/s² some 1e-5 m off. In these few steps position is integrated up to the joint and on from there, so that
it is the integral of the velocity there too.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from host.sim.trajectory.joints import LEAST
from host.sim.trajectory.nodes import advance, integrate_nodes, position_at_times
from host.sim.trajectory.segments import ChannelPieces
from host.sim.trajectory.tables import MotionTables

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


def kinks_of(channels: Mapping[str, ChannelPieces]) -> Integers:
    """Instants in ns, rising, at which a channel's rate steps."""
    found: set[int] = set()
    for channel in channels.values():
        slopes = [piece.derivative() for piece in channel.pieces]
        for k in range(1, len(slopes)):
            length_s = (channel.starts_ns[k] - channel.starts_ns[k - 1]) * 1e-9
            if abs(slopes[k].value(0.0) - slopes[k - 1].value(length_s)) > LEAST:
                found.add(int(channel.starts_ns[k]))
    return np.array(sorted(found), dtype=np.int64)


class Kinks:
    """Those of one path, on a grid of nodes 2^shift ns apart."""

    def __init__(self, channels: Mapping[str, ChannelPieces], tables: MotionTables, shift: int) -> None:
        instants = kinks_of(channels)
        inside = instants & ((1 << shift) - 1) != 0
        self._instants = instants[inside]
        self._steps = np.unique(self._instants >> shift)
        self._tables = tables
        self._shift = shift

    def __bool__(self) -> bool:
        return len(self._steps) > 0

    def integrate(self, first: int, position: Floats, nodes: Floats) -> None:
        """Fill `nodes` (n + 1, 6) from the node number `first` on, as `integrate_nodes` does."""
        layout, coefficients = self._tables.layout, self._tables.coefficients
        last = first + len(nodes) - 1
        begin = first
        for step in [*self._steps[(self._steps >= first) & (self._steps < last)].tolist(), last]:
            part = nodes[begin - first : step - first + 1]
            integrate_nodes(layout, coefficients, begin << self._shift, self._shift, position, part)
            if step < last:
                start = part[-1, :3].copy()
                position = self._integrated(step, start, (step + 1) << self._shift)
                begin = step + 1

    def correct(self, times_ns: Integers, nodes: Floats, start_ns: int, rows: Floats) -> None:
        """Move the positions in rows of truth at rising times of a chunk to where they belong."""
        steps = times_ns >> self._shift
        low, high = np.searchsorted(self._steps, (steps[0], steps[-1] + 1))
        for step in self._steps[low:high].tolist():
            begin, end = np.searchsorted(steps, (step, step + 1))
            for k in range(int(begin), int(end)):
                at_ns = int(times_ns[k])
                node = nodes[step - (start_ns >> self._shift), :3].copy()
                by_cubic = np.empty((1, 3))
                position_at_times(nodes, start_ns, self._shift, times_ns[k : k + 1], by_cubic)
                rows[k, :3] += self._integrated(step, node, at_ns) - by_cubic[0]

    def _integrated(self, step: int, position: Floats, to_ns: int) -> Floats:
        """From the beginning of a step to an instant in it."""
        begin = step << self._shift
        within = self._instants[(self._instants > begin) & (self._instants < to_ns)]
        for end in [*within.tolist(), to_ns]:
            if end > begin:
                after = np.empty(3)
                advance(self._tables.layout, self._tables.coefficients, begin, end, position, after)
                position, begin = after, end
        return position
