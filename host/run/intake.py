"""The host end of the board's wires: frames of the link become batches for the recorder.

Nothing here looks into the firmware: times are the board's clock, mapped to virtual time by its crystal.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from firmware.drivers import gnss_epoch as gnss
from firmware.link import frames
from host.link.attitude import SOLUTIONS, solution_rows
from host.link.decoder import LinkDecoder
from host.record.run_data import (
    NAVIGATING,
    BiasEstimate,
    GnssBatch,
    Innovation,
    MotionBatch,
    SolutionBatch,
)
from host.run.arrivals import Arrivals, Piece
from host.run.surroundings import Installation
from host.run.time_tags import TimeTags
from host.sim.truth import TruthBatch

Floats = NDArray[np.float64]
NANODEG = math.pi / 180.0 * 1e-9
HOST_PORT = "host"
SOLUTION_FIELDS = (
    "height",
    "velocity_ned",
    "yaw",
    "pitch",
    "roll",
    "sigma_position",
    "sigma_velocity",
    "sigma_attitude",
)
UPPER = np.triu_indices(9)


class Takes(Protocol):
    """Who takes what the board said: `host.record.recorder` while it runs."""

    def add_solution(self, solution: SolutionBatch, truth: MotionBatch) -> None:
        """Solutions with the truth at the same instants."""
        ...

    def add_gnss(self, epochs: GnssBatch, truth: MotionBatch) -> None:
        """Receiver epochs with the truth at the antenna."""
        ...

    def add_covariance(self, t: float, covariance: Floats) -> None:
        """The filter's covariance."""
        ...

    def add_innovation(self, innovation: Innovation) -> None:
        """Innovations of one GNSS update."""
        ...

    def add_bias(self, bias: BiasEstimate) -> None:
        """Slow filter states."""
        ...

    def add_event(self, t_ns: int, source: str, text: str) -> None:
        """What the board told in words."""
        ...

    def add_status(self, rows: Floats) -> None:
        """Its counters."""
        ...

    def add_sensor(self, rows: Floats) -> None:
        """The health of its inertial sensor."""
        ...

    def add_filters(self, which: Floats, status: Floats, solution: SolutionBatch, truth: MotionBatch) -> None:
        """What filters side by side take for the state."""
        ...


class Truths(Protocol):
    """Who knows what was true: `host.sim.world`."""

    def truth(self, times_ns: NDArray[np.int64]) -> TruthBatch:
        """At the vehicle's origin."""
        ...

    def antenna_truth(self, times_ns: NDArray[np.int64], lever_arm: Floats) -> TruthBatch:
        """At a point of the body."""
        ...


class Sight(Protocol):
    """Who knows when the receiver's epochs were valid."""

    def validity_ns(
        self, time_of_day_ms: NDArray[np.float64], otherwise_ns: NDArray[np.int64]
    ) -> NDArray[np.int64]:
        """Of epochs told by their UTC time of day."""
        ...


class LinkIntake:
    """Understands the host port of one board. `flush` hands over what has come since the last time.

    `virtual_ns`: the virtual time at which the processor's clock, since its last reset, showed so many ns;
    before that clock begins anew, `flush` is to be called.
    """

    def __init__(
        self,
        virtual_ns: Callable[[int], int],
        world: Truths,
        recorder: Takes,
        sight: Sight | None,
        installation: Installation,
    ) -> None:
        self.decoder = LinkDecoder()
        self.tags = TimeTags()
        self._world = world
        self._recorder = recorder
        self._sight = sight
        self._installation = installation
        self._virtual_ns = virtual_ns
        self._pieces: list[Piece] = []
        self._last_solution_ns = -1
        self.gather: Callable[[], None] = _nothing
        """Brings what has come over the wires, called first of all in `flush`."""

    def receive(self, pieces: Sequence[Piece]) -> None:
        """Bytes of the board's output, and when they ended."""
        self._pieces += pieces

    def flush(self) -> None:
        """Decode, pair with the truth, and give everything to the recorder."""
        self.gather()
        payloads: dict[int, list[bytes]] = {kind: [] for kind in frames.PAYLOADS}
        arrivals = Arrivals(self._pieces)
        self._pieces = []
        for kind, payload in self.decoder.feed_raw(arrivals.data):
            if kind in payloads:
                payloads[kind].append(payload)
            elif kind == frames.TEXT:
                at_ns = arrivals.text_ns(payload)
                self._recorder.add_event(at_ns, "board", payload.decode(errors="replace"))
        self._take_gnss(_rows(frames.GNSS, payloads))
        self._take_covariances(_rows(frames.COVARIANCE, payloads))
        for row in _rows(frames.INNOVATION, payloads):
            values = row[2:]
            self._recorder.add_innovation(
                Innovation(self._seconds(row[0]), values[:6], values[6:], int(row[1]))  # type: ignore[arg-type]
            )
        self._take_biases(_rows(frames.BIAS, payloads))
        self._take_status(_rows(frames.STATUS, payloads))
        self._take_sensor(_rows(frames.SENSOR, payloads))
        self._take_filters(_rows(frames.FILTER, payloads))
        for kind in SOLUTIONS:
            if payloads[kind]:
                self._take_solutions(solution_rows(kind, payloads[kind]))

    def _seconds(self, board_us: float) -> float:
        return self._virtual_ns(int(board_us) * 1000) / 1e9

    def _times_ns(self, board_us: list[int]) -> NDArray[np.int64]:
        return np.array([self._virtual_ns(us * 1000) for us in board_us], dtype=np.int64)

    def _take_solutions(self, rows: NDArray[np.void]) -> None:
        times_ns = self._times_ns(rows["time_us"].tolist())
        fresh = np.diff(times_ns, prepend=self._last_solution_ns) > 0
        rows, times_ns = rows[fresh], times_ns[fresh]
        if not len(rows):
            return
        self._last_solution_ns = int(times_ns[-1])
        numbers = {name: np.ascontiguousarray(rows[name]) for name in SOLUTION_FIELDS}
        solution = SolutionBatch(
            t=times_ns / 1e9,
            latitude=rows["lat_nanodeg"] * NANODEG,
            longitude=rows["lon_nanodeg"] * NANODEG,
            mode=rows["mode"].astype(np.int64),
            flags=rows["flags"].astype(np.int64),
            **numbers,
        )
        truth = self._world.antenna_truth(times_ns, self._installation.imu_lever_arm)
        self._recorder.add_solution(solution, motion(truth))

    def _take_gnss(self, rows: list[tuple[float, ...]]) -> None:
        if not rows:
            return
        table = np.array(rows, dtype=np.float64)
        tagged_ns = self._times_ns([int(row[0]) for row in rows])
        times_ns = tagged_ns if self._sight is None else self._sight.validity_ns(table[:, 1], tagged_ns)
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

    def _take_covariances(self, rows: list[tuple[float, ...]]) -> None:
        if not rows:
            return
        covariances = np.zeros((len(rows), 9, 9))
        rows_of, columns_of = UPPER
        covariances[:, rows_of, columns_of] = covariances[:, columns_of, rows_of] = np.array(rows)[:, 1:]
        for row, covariance in zip(rows, covariances, strict=True):
            if covariance[0, 0] > 0.0:
                self._recorder.add_covariance(self._seconds(row[0]), covariance)

    def _take_biases(self, rows: list[tuple[float, ...]]) -> None:
        if not rows:
            return
        times_ns = self._times_ns([int(row[0]) for row in rows])
        fresh = np.concatenate(([True], np.diff(times_ns) > 0))
        truth = self._body_biases(times_ns[fresh])
        kept = [row for row, is_fresh in zip(rows, fresh, strict=True) if is_fresh]
        for row, time_ns, true in zip(kept, times_ns[fresh], truth, strict=True):
            known = tuple(true.tolist()) if np.isfinite(true).all() else None
            self._recorder.add_bias(BiasEstimate(time_ns / 1e9, row[1:10], row[10:19], known))

    def _take_status(self, rows: list[tuple[float, ...]]) -> None:
        """Its counters of trouble: everything behind gnss_epochs and imu_reads but the last."""
        if rows:
            counters = np.array([[self._seconds(row[0]), *row[5:11]] for row in rows], dtype=np.float64)
            self._recorder.add_status(counters)

    def _take_sensor(self, rows: list[tuple[float, ...]]) -> None:
        if rows:
            told = np.array([[self._seconds(row[0]), *row[1:]] for row in rows], dtype=np.float64)
            self._recorder.add_sensor(told)

    def _take_filters(self, rows: list[tuple[float, ...]]) -> None:
        """`which` and `status` beside a solution, each row at a time of its own."""
        if not rows:
            return
        table = np.array(rows, dtype=np.float64)
        times_ns = self._times_ns([int(row[0]) for row in rows])
        solution = SolutionBatch(
            t=times_ns / 1e9,
            latitude=table[:, 3] * NANODEG,
            longitude=table[:, 4] * NANODEG,
            height=table[:, 5],
            velocity_ned=table[:, 6:9],
            yaw=table[:, 9],
            pitch=table[:, 10],
            roll=table[:, 11],
            sigma_position=table[:, 12:15],
            sigma_velocity=table[:, 15:18],
            sigma_attitude=table[:, 18:21],
            mode=np.full(len(rows), NAVIGATING),
            flags=np.zeros(len(rows), np.int64),
        )
        instants, places = np.unique(times_ns, return_inverse=True)
        truth = motion(self._world.antenna_truth(instants, self._installation.imu_lever_arm))
        there = MotionBatch(*(getattr(truth, name)[places] for name in MotionBatch.__slots__))
        self._recorder.add_filters(table[:, 1], table[:, 2], solution, there)

    def _body_biases(self, times_ns: NDArray[np.int64]) -> Floats:
        """True gyro and accelerometer biases in body axes, (n, 6); NaN where nobody knows them."""
        truth = self._world.truth(times_ns)
        rotation = self._installation.C_b_s.T
        return np.hstack([truth.bias_g @ rotation, truth.bias_a @ rotation])


def _nothing() -> None:
    pass


def _rows(kind: int, payloads: dict[int, list[bytes]]) -> list[tuple[float, ...]]:
    unpack = frames.PAYLOADS[kind].unpack
    return [unpack(payload) for payload in payloads[kind]]


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
    from_course = np.stack(
        [speed * np.cos(course), speed * np.sin(course), np.full(len(table), np.nan)], axis=1
    )
    has_course = ((flags & gnss.HAS_SPEED) != 0) & ((flags & gnss.HAS_COURSE) != 0)
    from_course[~has_course] = np.nan
    return np.where(((flags & gnss.HAS_VELOCITY) != 0)[:, None], table[:, 10:13] * 1e-3, from_course)
