"""A capture as a world: chips feel what was measured, receivers see the epochs that were received."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from boards.chips.world import GnssEpoch, ImuWorld, TenDofWorld
from boards.description import Board
from host.capture.blocks import I2cTransaction, SpiTransaction
from host.capture.inertial_samples import InertialSamples, register_access
from host.capture.number_rows import check_numbers
from host.capture.reader import CaptureReader, Decoded
from host.capture.sensor_traffic import DECODERS
from host.record.errors import UserError
from host.record.run_data import NAVIGATING
from host.replay.road import NS, POSITION, ROAD_COLUMNS, VELOCITY, Road
from host.sim.gnss.schedule import Window, held, window
from host.sim.gnss.slow_sky import SlowSky
from host.sim.recording.recorded_imu import RecordedImu
from host.sim.scenario.schema import Scenario
from host.sim.truth import TruthBatch
from host.sim.world import World

Array = NDArray[np.float64]
LONGEST_EPOCH_STEP_S = 1.1
"""Epochs further apart than this are not interpolated between: there is no fix."""
H_ACC_M, V_ACC_M, S_ACC_MPS = 3.0, 5.0, 0.1
"""What a receiver of this kind claims under an open sky, where epochs hold no accuracies."""
EPOCH_COLUMNS = ("fix", *POSITION, *VELOCITY)
"""What is needed of every epoch, besides its time."""
CLAIMED = ("h_acc_m", "v_acc_m", "s_acc_mps", "latency_s", "geoid_separation_m")
"""What only imported epochs may hold."""


class RecordedEpochs:
    """Implements `boards.chips.world.GnssWorld` from rows of /gnss, linear between neighbours with a fix.

    NMEA tells no vertical velocity; that of the recorded solution then takes its place.
    """

    def __init__(
        self,
        rows: Sequence[Mapping[str, Any]],
        solutions: Sequence[Mapping[str, Any]],
        scenario: Scenario,
        outages: Sequence[Window],
    ) -> None:
        fixed = [row for row in rows if row["fix"] == 1 and row["height_m"] is not None]
        self._t = np.array([row["t_s"] for row in fixed], dtype=np.float64)
        table = [[row[name] for name in (*POSITION, *VELOCITY)] for row in fixed]
        self._rows = np.array(table, dtype=np.float64).reshape(-1, 6)
        self._rows[:, :2] = np.radians(self._rows[:, :2])
        missing = np.isnan(self._rows[:, 5])
        self._rows[missing, 5] = _climb(solutions, self._t[missing])
        settings = scenario.gnss
        separation = 0.0 if scenario.place is None else scenario.place.geoid_separation_m
        usual = (H_ACC_M, V_ACC_M, S_ACC_MPS, settings.latency_s, separation)
        told = np.array([[row.get(name) for name in CLAIMED] for row in fixed], dtype=np.float64).reshape(
            -1, 5
        )
        self._rows = np.hstack((np.nan_to_num(self._rows), np.where(np.isnan(told), usual, told)))
        self._start = scenario.start
        self._outages = list(outages)
        self._sky = SlowSky(
            scenario.start.gps_time_ns, settings.constellations, math.radians(settings.elevation_mask_deg)
        )

    def epoch(self, time_ns: int) -> GnssEpoch:
        """The recorded solution at `time_ns`."""
        state, fix = self._at(time_ns / NS)
        lat, lon, height, vn, ve, vd, h_acc, v_acc, s_acc, latency_s, separation = state
        sky = self._sky.above(time_ns, lat, lon, height, is_open=not held(self._outages, time_ns))
        return GnssEpoch(
            fix=fix,
            time_known=True,
            gps_time_ns=self._start.gps_time_ns + time_ns,
            leap_seconds=self._start.leap_seconds,
            latitude=lat,
            longitude=lon,
            height=height,
            geoid_separation=separation,
            velocity_ned=(vn, ve, vd),
            h_acc=h_acc,
            v_acc=v_acc,
            s_acc=s_acc,
            pdop=sky.pdop,
            hdop=sky.hdop,
            vdop=sky.vdop,
            tdop=sky.tdop,
            satellites=sky.satellites,
            latency_ns=max(1_000_000, round(latency_s * NS)),
        )

    def _at(self, t: float) -> tuple[list[float], bool]:
        times = self._t
        if not len(times):
            return [0.0] * 6 + [H_ACC_M, V_ACC_M, S_ACC_MPS, 0.0, 0.0], False
        k = int(np.searchsorted(times, t))
        before, after = max(k - 1, 0), min(k, len(times) - 1)
        nearest = before if t - times[before] < times[after] - t else after
        if abs(times[nearest] - t) < 0.001:
            return self._rows[nearest].tolist(), True
        span = times[after] - times[before]
        if before == after or span > LONGEST_EPOCH_STEP_S:
            return self._rows[nearest].tolist(), False
        x = (t - times[before]) / span
        state: list[float] = (self._rows[before] + x * (self._rows[after] - self._rows[before])).tolist()
        return state, True


def _climb(solutions: Sequence[Mapping[str, Any]], t: Array) -> Array:
    """Downward velocity of the recorded solution; 0 where there is none."""
    known = [row for row in solutions if (row["mode"] or 0) >= NAVIGATING and row["v_down_mps"] is not None]
    if not known:
        return np.zeros(len(t))
    times = [row["t_s"] for row in known]
    climb: Array = np.interp(t, times, [row["v_down_mps"] for row in known], left=0.0)
    return climb


class FeltImu(RecordedImu):
    """A recorded sensor with its temperature."""

    def __init__(self, samples: InertialSamples, C_b_s: Array, mounting: Array) -> None:
        """`C_b_s` of the recorded chip, `mounting` of the one that feels it now."""
        super().__init__(
            samples.times_ns.astype(np.float64), samples.force @ C_b_s.T, samples.rate @ C_b_s.T, mounting
        )
        self._warm = samples.temperature_times_ns, samples.temperature

    def sample(self, times_ns: NDArray[np.int64], bandwidth_hz: float) -> Array:
        """Linear between the recorded samples."""
        out = super().sample(times_ns, bandwidth_hz)
        if len(self._warm[0]):
            out[:, 6] = np.interp(times_ns, *self._warm)
        return out


class FeltRecordedField:
    """A recorded sensor with its magnetometers and barometer: implements `boards.chips.world.TenDofWorld`."""

    def __init__(self, imu: ImuWorld, samples: InertialSamples, C_b_s: Array, mounting: Array) -> None:
        """`C_b_s` of the recorded chip, `mounting` of the one that feels it now."""
        assert samples.field is not None
        assert samples.pressure is not None
        self._imu = imu
        self._times_ns = samples.times_ns
        self._columns = [*(samples.field @ C_b_s.T @ mounting).T, samples.pressure]

    def sample(self, times_ns: NDArray[np.int64], bandwidth_hz: float) -> Array:
        """Linear between the recorded samples."""
        out = np.empty((len(times_ns), 11))
        out[:, :7] = self._imu.sample(times_ns, bandwidth_hz)
        for place, column in enumerate(self._columns, start=7):
            out[:, place] = np.interp(times_ns, self._times_ns, column)
        return out


class RecordedVehicle:
    """Implements `host.sim.world.Vehicle` from a capture that has been read."""

    looks_ahead = False

    def __init__(self, scenario: Scenario, capture: RecordedContent, duration_ns: int) -> None:
        self.duration_ns = duration_ns
        self.outages: tuple[Window, ...] = tuple(window(o.start_s, o.duration_s) for o in scenario.outage)
        self.road = capture.road
        self._scenario = scenario
        self._capture = capture

    def imu(self, name: str, mounting: Array, lever_arm: Array, preset: str | None = None) -> FeltImu:
        """The recorded sensor of that designator (or the only one), turned into the chip's axes."""
        samples = self._capture.samples
        source = name if name in samples else next(iter(samples))
        return FeltImu(samples[source], self._capture.mountings[source], mounting)

    def ambient(self, imu: ImuWorld, name: str, mounting: Array) -> FeltRecordedField | None:
        """What the recorded sensor felt beside its motion; None: it has no magnetometers or no barometer."""
        samples = self._capture.samples
        source = name if name in samples else next(iter(samples))
        found = samples[source]
        if found.field is None or found.pressure is None:
            return None
        return FeltRecordedField(imu, found, self._capture.mountings[source], mounting)

    def gnss(self, name: str, lever_arm: Array, second_lever_arm: Array | None = None) -> RecordedEpochs:
        """The recorded receiver."""
        return RecordedEpochs(self._capture.epochs, self._capture.climbs, self._scenario, self.outages)

    def truth(self, times_ns: NDArray[np.int64], imu: str | None = None) -> TruthBatch:
        """Of the navigation point; the sensor's true bias is not known."""
        return self.road.truth(times_ns)

    def antenna_truth(self, times_ns: NDArray[np.int64], lever_arm: Array) -> TruthBatch:
        """Of a point of the body."""
        return self.road.truth(times_ns, lever_arm - self._capture.road_lever_arm)


class RecordedWorld(World):
    """A world whose vehicle is a capture. Faults of the receiver are in what was received."""

    def __init__(self, scenario: Scenario, vehicle: RecordedVehicle) -> None:
        self.scenario = scenario.model_copy(update={"fault": []})
        self.seed = 1
        self._vehicle: RecordedVehicle = vehicle

    def ten_dof(
        self,
        name: str,
        mounting: Array | None = None,
        lever_arm: Array | None = None,
        preset: str | None = None,
    ) -> TenDofWorld:
        """Field and pressure as recorded, or, where no sensor felt them, as the road's places have them."""
        rotation = np.eye(3) if mounting is None else np.asarray(mounting, dtype=np.float64)
        imu = self.imu(name, rotation, lever_arm, preset)
        recorded = self._vehicle.ambient(imu, name, rotation)
        return super().ten_dof(name, rotation, lever_arm, preset) if recorded is None else recorded

    def another(self) -> RecordedWorld:
        """The same: a capture has no state."""
        return self


def _places_on_i2c(board: Board) -> dict[tuple[str, int], tuple[str, int]]:
    """Bus and address of the inertial sensors on I²C: which one it is, and the bus's clock in Hz.

    A BMI160 has the address 0x69 when its pin SDO is high, else 0x68 (fact sheet, on I²C).
    """
    places = {}
    for refdes, chip in board.chips.items():
        bus = board.buses.get(chip.bus or "")
        if bus is not None and bus.kind == "i2c" and chip.part in DECODERS:
            address = 0x69 if chip.parameters.get("sdo_high") else 0x68
            places[str(chip.bus), address] = f"{chip.bus}.{chip.name or refdes}", bus.clock_hz
    return places


class RecordedContent(Protocol):
    """What a physical replay needs of a capture."""

    samples: dict[str, InertialSamples]
    """Of each inertial sensor."""
    mountings: dict[str, Array]
    """C_b_s of each."""
    road: Road
    road_lever_arm: Array
    """Of the point whose road it is, from the origin of the body, m."""
    epochs: list[dict[str, Any]]
    """Rows of /gnss."""
    climbs: list[dict[str, Any]]
    """Rows of /solution, for the vertical velocity that epochs may lack."""
    end_ns: int


class CaptureContent:
    """Implements `RecordedContent` of a run's capture, in memory: some 60 bytes a sample."""

    def __init__(self, reader: CaptureReader, recorded_board: Board) -> None:
        """Reads all of it. Raises UserError when there is no inertial sensor that can be decoded."""
        rows: dict[str, list[dict[str, Any]]] = {"/solution": [], "/gnss": []}
        columns = {"/solution": ROAD_COLUMNS, "/gnss": EPOCH_COLUMNS}
        self.end_ns = 0
        traffic = {
            f"{chip.bus}.{chip.name or refdes}": (refdes, DECODERS[chip.part]())
            for refdes, chip in recorded_board.chips.items()
            if chip.bus is not None and chip.part in DECODERS
        }
        on_i2c = _places_on_i2c(recorded_board)
        for record in reader:
            if isinstance(record, SpiTransaction):
                self.end_ns = max(self.end_ns, record.end_ns)
                if record.bus in traffic:
                    traffic[record.bus][1].add((record,))
            elif isinstance(record, I2cTransaction):
                self.end_ns = max(self.end_ns, record.transfer.end_ns)
                place = on_i2c.get((record.bus, record.transfer.address))
                access = None if place is None else register_access(record.transfer, place[1])
                if place is not None and access is not None:
                    traffic[place[0]][1].add((access,))
            elif isinstance(record, Decoded) and record.topic in rows:
                check_numbers(
                    record.value, columns[record.topic], f"capture {reader.path}: a row of {record.topic}"
                )
                rows[record.topic].append(record.value)
        self.epochs, self.climbs = rows["/gnss"], rows["/solution"]
        self.road = Road(self.climbs)
        self.mountings = {refdes: np.array(chip.mounting) for refdes, chip in recorded_board.chips.items()}
        self.samples = {refdes: decoder.samples() for refdes, decoder in traffic.values()}
        self.samples = {refdes: found for refdes, found in self.samples.items() if len(found.times_ns) > 1}
        if not self.samples:
            raise UserError(
                f"capture {reader.path}: no inertial samples in it; known are the parts {', '.join(DECODERS)}"
            )
        sensors = [chip for chip in recorded_board.chips.values() if chip.is_inertial]
        self.road_lever_arm = np.array(sensors[0].lever_arm_m)
        """The road is that of the recorded sensor."""
