"""A vehicle's motion: truth at any instant of virtual time, in flat memory however long the run.

Nodes of the position are computed in chunks of 2³⁵ ns (34.4 s) when they are first asked for; the position
at each chunk's start is kept (24 bytes), the chunks themselves only while they are in use, and a chunk that
is asked for again comes out the same.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Sequence
from copy import copy

import numpy as np
from numpy.typing import NDArray

from host.sim.compiled import Floats, Integers, entry
from host.sim.trajectory.disturbance import Disturbance
from host.sim.trajectory.kinematics import LATITUDE, ROW, motion_rows
from host.sim.trajectory.kinks import Kinks
from host.sim.trajectory.lanes import ANGLE, ANGLES, LANES, PATH, PLACE, fill_sines, follow_path, shake_path
from host.sim.trajectory.nodes import position_at
from host.sim.trajectory.segments import MotionState, Segment, build_channels
from host.sim.trajectory.shaking import shaking
from host.sim.trajectory.tables import MotionTables, compile_tables

CHUNK_SHIFT = 35
NODE_SHIFT = 25
"""33.6 ms: with a snap of 200 m/s⁴ between nodes the position errs by less than a micrometre."""
CHUNKS_KEPT = 8


class Motion:
    """Position, velocity, attitude and what perfect sensors feel, as functions of time."""

    def __init__(
        self,
        segments: Sequence[Segment],
        initial: MotionState,
        origin: tuple[float, float, float],
        blend_s: float = 0.5,
        disturbance: Disturbance | None = None,
    ) -> None:
        """`origin` = latitude, longitude in rad, height in m at time 0; `blend_s` as in `Segment.rates`."""
        disturbance = disturbance or Disturbance()
        channels, self.end_ns = build_channels(segments, initial, blend_s)
        self.channels = channels
        self.tables: MotionTables = compile_tables(channels, disturbance)
        self._starts = [np.array(origin, dtype=np.float64)]
        self._chunks: OrderedDict[int, NDArray[np.float64]] = OrderedDict()
        self._kinks = Kinks(channels, self.tables, NODE_SHIFT)
        self._put_down: tuple[int, Motion] | None = None
        """When somebody put the vehicle elsewhere, and its motion there."""

    def put_down(self, time_ns: int, place: tuple[float, float, float]) -> None:
        """From `time_ns` on the vehicle stands at `place` (as `origin`). It must be standing by then, and
        must not have been put down later before."""
        if self._put_down is not None:
            self._put_down[1].put_down(time_ns, place)
            return
        there = copy(self)
        there._starts = [np.array(place, dtype=np.float64)] * ((time_ns >> CHUNK_SHIFT) + 1)
        there._chunks = OrderedDict()
        self._put_down = time_ns, there

    def rows(self, times_ns: NDArray[np.int64]) -> NDArray[np.float64]:
        """Rows of truth (n, 24) at rising times ≥ 0; columns as in `host.sim.trajectory.kinematics`."""
        times_ns = np.ascontiguousarray(times_ns, dtype=np.int64)
        if self._put_down is None:
            return self._rows_here(times_ns)
        from_ns, there = self._put_down
        before = int(np.searchsorted(times_ns, from_ns))
        return np.concatenate((self._rows_here(times_ns[:before]), there.rows(times_ns[before:])))

    def _rows_here(self, times_ns: NDArray[np.int64]) -> NDArray[np.float64]:
        out = np.empty((len(times_ns), ROW))
        for chunk, part in split_by_chunk(times_ns):
            nodes, start_ns = self.nodes(chunk), chunk << CHUNK_SHIFT
            fill_rows(*self.tables, nodes, start_ns, NODE_SHIFT, times_ns[part], out[part])
            if self._kinks:
                self._kinks.correct(times_ns[part], nodes, start_ns, out[part])
        return out

    def nodes(self, chunk: int) -> NDArray[np.float64]:
        """Nodes of the chunk that covers [chunk, chunk + 1] · 2³⁵ ns."""
        nodes = self._chunks.get(chunk)
        if nodes is not None:
            self._chunks.move_to_end(chunk)
            return nodes
        for index in range(len(self._starts) - 1, chunk):
            self._starts.append(self._integrate(index)[-1, :3].copy())
        nodes = self._integrate(chunk)
        if chunk + 1 == len(self._starts):
            self._starts.append(nodes[-1, :3].copy())
        self._chunks[chunk] = nodes
        if len(self._chunks) > CHUNKS_KEPT:
            self._chunks.popitem(last=False)
        return nodes

    def _integrate(self, chunk: int) -> NDArray[np.float64]:
        nodes = np.empty(((1 << (CHUNK_SHIFT - NODE_SHIFT)) + 1, 6))
        self._kinks.integrate(chunk << (CHUNK_SHIFT - NODE_SHIFT), self._starts[chunk], nodes)
        return nodes


def split_by_chunk(times_ns: NDArray[np.int64]) -> list[tuple[int, slice]]:
    """Chunk numbers and the slices of rising times that fall into them."""
    if len(times_ns) == 0:
        return []
    first, last = int(times_ns[0]) >> CHUNK_SHIFT, int(times_ns[-1]) >> CHUNK_SHIFT
    if first < 0:
        raise ValueError(f"time {times_ns[0]} ns lies before the start of the run; times begin at 0")
    if first == last:
        return [(first, slice(0, len(times_ns)))]
    limits = np.searchsorted(times_ns, [k << CHUNK_SHIFT for k in range(first, last + 2)])
    pairs = zip(range(first, last + 1), limits[:-1], limits[1:], strict=True)
    return [(chunk, slice(int(a), int(b))) for chunk, a, b in pairs if b > a]


@entry
def fill_rows(
    layout: Integers,
    coefficients: Floats,
    bank: Floats,
    constants: Floats,
    nodes: Floats,
    start_ns: int,
    shift: int,
    times_ns: Integers,
    out: Floats,
) -> None:
    """Rows of truth at times within one chunk, LANES at a time; what the last ones leave free is unused."""
    row = layout[:4].copy()
    times = np.zeros(LANES)
    sums = np.empty((3, LANES))
    shake = np.empty((6, 3, LANES))
    path = np.zeros((PATH, LANES))
    angles = np.zeros((3, ANGLES, LANES))
    truth = np.zeros((ROW, LANES))
    for first in range(0, times_ns.shape[0], LANES):
        count = min(LANES, times_ns.shape[0] - first)
        for j in range(count):
            times[j] = times_ns[first + j] * 1e-9
        shaking(layout, bank, times, sums, shake)
        for j in range(count):
            t_ns = times_ns[first + j]
            position_at(nodes, start_ns, shift, t_ns, j, truth)
            angles[ANGLE, PLACE, j] = truth[LATITUDE, j]
            follow_path(layout, coefficients, row, t_ns, j, path)
        shake_path(constants, path, shake, angles)
        fill_sines(angles)
        motion_rows(constants, times, path, angles, shake, truth)
        for j in range(count):
            for k in range(ROW):
                out[first + j, k] = truth[k, j]
