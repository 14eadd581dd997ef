"""The host end of the board's wires: frames of the link become batches for the recorder.

Nothing here looks into the firmware: times are the board's clock, mapped to virtual time by its crystal.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from boards.assembly import AssembledBoard
from firmware.drivers import gnss_epoch as gnss
from firmware.link import frames
from host.link.decoder import LinkDecoder
from host.record.recorder import Recorder
from host.record.run_data import BiasEstimate, GnssBatch, Innovation, MotionBatch, SolutionBatch
from host.run.surroundings import Installation, ReceiverSight
from host.run.time_tags import TimeTags
from host.sim.truth import TruthBatch
from host.sim.world import World

Floats = NDArray[np.float64]
NANODEG = math.pi / 180.0 * 1e-9
UPPER = np.triu_indices(9)


class LinkIntake:
    """Listens at the host port of one board. `flush` hands over what has come since the last time."""

    def __init__(
        self,
        board: AssembledBoard,
        world: World,
        recorder: Recorder,
        sight: ReceiverSight,
        installation: Installation,
        port: str = "host",
    ) -> None:
        self.decoder = LinkDecoder()
        self.tags = TimeTags()
        self._world = world
        self._recorder = recorder
        self._sight = sight
        self._installation = installation
        self._virtual_ns: Callable[[int], int] = board.cpus[board.description.uarts[port].processor].virtual_ns
        self._bytes = bytearray()
        self._rows: dict[int, list[tuple[float, ...]]] = {kind: [] for kind in frames.PAYLOADS}
        self._last_solution_ns = -1
        board.from_board[port].connect(self)

    def receive(self, data: bytes, time_ns: int) -> None:
        """A chunk of the board's output has ended at `time_ns`."""
        self._bytes += data
        if len(self._bytes) > 1 << 14:
            self._decode(time_ns)

    def flush(self, now_ns: int) -> None:
        """Decode, pair with the truth, and give everything to the recorder."""
        self._decode(now_ns)
        rows = self._rows
        self._rows = {kind: [] for kind in frames.PAYLOADS}
        self._take_gnss(rows[frames.GNSS])
        for row in rows[frames.COVARIANCE]:
            self._take_covariance(row)
        for row in rows[frames.INNOVATION]:
            values = row[2:]
            self._recorder.add_innovation(
                Innovation(self._seconds(row[0]), values[:6], values[6:], int(row[1]))  # type: ignore[arg-type]
            )
        self._take_biases(rows[frames.BIAS])
        self._take_solutions(rows[frames.SOLUTION])

    def _decode(self, now_ns: int) -> None:
        for kind, fields in self.decoder.feed(bytes(self._bytes)):
            if isinstance(fields, str):
                self._recorder.add_event(now_ns, "board", fields)
            else:
                self._rows[kind].append(fields)
        self._bytes.clear()

    def _seconds(self, board_us: float) -> float:
        return self._virtual_ns(int(board_us) * 1000) / 1e9

    def _take_solutions(self, rows: list[tuple[float, ...]]) -> None:
        if not rows:
            return
        table = np.array(rows)
        times_ns = np.array([self._virtual_ns(int(row[0]) * 1000) for row in rows], dtype=np.int64)
        fresh = np.diff(times_ns, prepend=self._last_solution_ns) > 0
        table, times_ns = table[fresh], times_ns[fresh]
        if not len(table):
            return
        self._last_solution_ns = int(times_ns[-1])
        position = np.array([(row[5], row[6]) for row in rows], dtype=np.float64)[fresh] * NANODEG
        solution = SolutionBatch(
            t=times_ns / 1e9,
            latitude=position[:, 0],
            longitude=position[:, 1],
            height=table[:, 7],
            velocity_ned=table[:, 8:11],
            yaw=table[:, 11],
            pitch=table[:, 12],
            roll=table[:, 13],
            sigma_position=table[:, 17:20],
            sigma_velocity=table[:, 20:23],
            sigma_attitude=table[:, 23:26],
            mode=table[:, 3].astype(np.int64),
            flags=table[:, 4].astype(np.int64),
        )
        self._recorder.add_solution(solution, motion(self._world.truth(times_ns)))

    def _take_gnss(self, rows: list[tuple[float, ...]]) -> None:
        if not rows:
            return
        table = np.array(rows, dtype=np.float64)
        tagged_ns = np.array([self._virtual_ns(int(row[0]) * 1000) for row in rows], dtype=np.int64)
        times_ns = self._sight.validity_ns(table[:, 1], tagged_ns)
        order = np.concatenate(([True], np.diff(times_ns) > 0))
        table, times_ns, tagged_ns = table[order], times_ns[order], tagged_ns[order]
        flags = table[:, 3].astype(np.int64)
        velocity = _velocity(table, flags)
        epochs = GnssBatch(
            t=times_ns / 1e9,
            fix=(flags & gnss.HAS_POSITION) != 0,
            latitude=table[:, 4] * NANODEG,
            longitude=table[:, 5] * NANODEG,
            height=np.where(flags & gnss.HAS_HEIGHT, table[:, 6] * 1e-3, np.nan),
            velocity_ned=velocity,
        )
        truth = self._world.antenna_truth(times_ns, self._installation.antenna_lever_arm)
        self.tags.add(tagged_ns - times_ns, truth.v_ned)
        self._recorder.add_gnss(epochs, motion(truth))

    def _take_covariance(self, row: tuple[float, ...]) -> None:
        covariance = np.zeros((9, 9))
        covariance[UPPER] = row[1:]
        covariance = covariance + np.triu(covariance, 1).T
        if covariance[0, 0] > 0.0:
            self._recorder.add_covariance(self._seconds(row[0]), covariance)

    def _take_biases(self, rows: list[tuple[float, ...]]) -> None:
        if not rows:
            return
        times_ns = np.array([self._virtual_ns(int(row[0]) * 1000) for row in rows], dtype=np.int64)
        fresh = np.concatenate(([True], np.diff(times_ns) > 0))
        truth = self._body_biases(times_ns[fresh])
        kept = [row for row, is_fresh in zip(rows, fresh, strict=True) if is_fresh]
        for row, time_ns, true in zip(kept, times_ns[fresh], truth, strict=True):
            known = tuple(true.tolist()) if np.isfinite(true).all() else None
            self._recorder.add_bias(BiasEstimate(time_ns / 1e9, row[1:10], row[10:19], known))

    def _body_biases(self, times_ns: NDArray[np.int64]) -> Floats:
        """True gyro and accelerometer biases in body axes, (n, 6); NaN where nobody knows them."""
        truth = self._world.truth(times_ns)
        rotation = self._installation.C_b_s.T
        return np.hstack([truth.bias_g @ rotation, truth.bias_a @ rotation])


def motion(truth: TruthBatch) -> MotionBatch:
    """Truth of the world in the recorder's form."""
    return MotionBatch(
        t=truth.times_ns / 1e9,
        latitude=truth.latitude,
        longitude=truth.longitude,
        height=truth.height,
        velocity_ned=truth.v_ned,
        yaw=truth.yaw,
        pitch=truth.pitch,
        roll=truth.roll,
    )


def _velocity(table: Floats, flags: NDArray[np.int64]) -> Floats:
    """North, east, down from three components, or from speed and course; NaN where not told."""
    course = np.radians(table[:, 9] * 1e-5)
    speed = table[:, 8] * 1e-3
    from_course = np.stack([speed * np.cos(course), speed * np.sin(course), np.full(len(table), np.nan)], axis=1)
    has_course = ((flags & gnss.HAS_SPEED) != 0) & ((flags & gnss.HAS_COURSE) != 0)
    from_course[~has_course] = np.nan
    return np.where(((flags & gnss.HAS_VELOCITY) != 0)[:, None], table[:, 10:13] * 1e-3, from_course)
