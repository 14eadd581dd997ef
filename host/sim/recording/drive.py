"""A recorded drive behind the same doors as the simulated vehicle.

Virtual time 0 is the first whole second of GPS time at which IMU, GNSS and reference are all there, so that
the receiver's epochs fall on round instants as they did on the road. The reference is the device's own pose;
the antenna's lever arm is not known, hence truth at the antenna is that of the device.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from host.sim.gnss.schedule import NS, Window, window
from host.sim.gnss.tunnels import with_tunnels
from host.sim.recording.comma2k19 import LEAP_SECONDS, Comma2k19, read_comma2k19
from host.sim.recording.locate import recording_path
from host.sim.recording.recorded_imu import RecordedImu
from host.sim.recording.recorded_receiver import RecordedReceiver
from host.sim.recording.reference import PoseReference
from host.sim.scenario.errors import ScenarioError
from host.sim.scenario.schema import Scenario
from host.sim.truth import TruthBatch

Array = NDArray[np.float64]


class RecordedDrive:
    """Implements `host.sim.world.Vehicle` from a comma2k19 example."""

    looks_ahead = False

    def __init__(self, scenario: Scenario, data_dir: Path | None) -> None:
        """ScenarioError when the recording is missing, unreadable or shorter than the scenario."""
        source = scenario.recording
        assert source is not None  # the schema asks for it
        self._scenario = scenario
        self._geoid_separation = source.geoid_separation_m
        path = recording_path(source.file, data_dir)
        drive = read_comma2k19(path, source.gyro == "calibrated")
        self._drive = drive
        self._start_gps_s, self._start_t = _start(drive)
        end_t = min(drive.imu_t[-1], drive.pose_t[-1], drive.gnss_valid_t[-1])
        length_s = math.floor(10.0 * (end_t - self._start_t)) / 10.0
        wanted_s = length_s if scenario.duration_s is None else scenario.duration_s
        if wanted_s > length_s:
            raise ScenarioError(
                f"{scenario.path or scenario.name}: duration_s = {wanted_s:g}: the recording {source.file} "
                f"lasts {length_s:g} s; for example duration_s = {length_s:g}"
            )
        self.duration_ns = round(wanted_s * NS)
        self._reference = PoseReference(
            self._virtual(drive.pose_t), drive.pose_position, drive.pose_velocity, drive.pose_q_eb
        )
        self.outages: tuple[Window, ...] = with_tunnels(
            [window(o.start_s, o.duration_s) for o in scenario.outage],
            [tunnel.polygon for tunnel in scenario.tunnel],
            self._places,
            self.duration_ns,
        )

    def _virtual(self, boot_t: Array) -> Array:
        """Seconds on the boot clock as virtual ns."""
        return (boot_t - self._start_t) * NS

    def imu(self, name: str, mounting: Array, lever_arm: Array, preset: str | None = None) -> RecordedImu:
        """The recorded sensor, turned into the chip's axes; name, lever arm and preset do not matter."""
        drive = self._drive
        return RecordedImu(self._virtual(drive.imu_t), drive.force, drive.rate, mounting)

    def gnss(self, name: str, lever_arm: Array, second_lever_arm: Array | None = None) -> RecordedReceiver:
        """The recorded receiver; name and lever arms do not matter, and of a baseline it knows nothing."""
        drive, settings = self._drive, self._scenario.gnss
        return RecordedReceiver(
            self._virtual(drive.gnss_valid_t),
            self._virtual(drive.gnss_arrival_t),
            drive.gnss_position,
            drive.gnss_velocity,
            self._start_gps_s * NS,
            LEAP_SECONDS,
            self._geoid_separation,
            settings.constellations,
            math.radians(settings.elevation_mask_deg),
            self.outages,
            round(settings.reacquisition_s * NS),
        )

    def _places(self, times_ns: NDArray[np.int64]) -> tuple[Array, Array]:
        truth = self._reference.truth(times_ns)
        return truth.latitude, truth.longitude

    def truth(self, times_ns: NDArray[np.int64], imu: str | None = None) -> TruthBatch:
        """The reference; the sensor's true bias is not known."""
        return self._reference.truth(times_ns)

    def antenna_truth(self, times_ns: NDArray[np.int64], lever_arm: Array) -> TruthBatch:
        """The reference: the antenna's place on the car is not known."""
        return self._reference.truth(times_ns)


def _start(drive: Comma2k19) -> tuple[int, float]:
    """GPS time in s and boot time of virtual time 0."""
    first_t = max(drive.imu_t[0], drive.pose_t[0], drive.gnss_valid_t[0])
    gps_of_boot = drive.gnss_gps_ms[0] * 1e-3 - drive.gnss_valid_t[0]
    start_gps_s = math.ceil(round(first_t + gps_of_boot, 6))
    return start_gps_s, start_gps_s - gps_of_boot
