"""The program of the TMS320F28335: initialisation, interrupts, tasks and the background loop.

imu_timer (250 Hz) ─► attitude (125 Hz) ─► output
                                       main: the sensor's health, announcements, watchdog
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from firmware.apps.uav_ahrs.announcements import Announcer
from firmware.apps.uav_ahrs.attitude import Attitude, attitude_config
from firmware.apps.uav_ahrs.background import Background
from firmware.apps.uav_ahrs.kernels import AttitudeKernels
from firmware.apps.uav_ahrs.output import Output
from firmware.apps.uav_ahrs.sensor import Sensor
from firmware.apps.uav_ahrs.settings import Settings
from firmware.apps.uav_ahrs.startup import initialise
from firmware.apps.uav_ahrs.steps import SPOILT
from hal.board_io import BoardIo


def program(io: BoardIo, profile: Mapping[str, Any], installation: Mapping[str, Any]) -> UavAhrs:
    """The image in flash. Raises ValueError for a profile that no program could mean."""
    return UavAhrs(io, Settings.of(profile), installation)


class UavAhrs:
    """Implements `hal.board_io.Program`."""

    def __init__(self, io: BoardIo, settings: Settings, installation: Mapping[str, Any]) -> None:
        self._io = io
        self._settings = settings
        self._kernels = AttitudeKernels(settings.arithmetic, settings.drift_compensation)
        self._config = attitude_config(settings, installation)
        self._attitude: Attitude | None = None

    def main(self) -> None:
        """From the reset vector: nothing survives a reset."""
        io, settings = self._io, self._settings
        attitude = Attitude(self._kernels, self._config)
        self._attitude = attitude
        sensor = Sensor(io, attitude, settings)
        output = Output(io, settings, attitude, sensor)
        tasks = AttitudeTasks(io, settings, attitude, output)
        sensor.ready = tasks.line.pend
        announcer = Announcer(io.clock, attitude, output)
        background = Background(io, attitude, sensor, output, announcer, settings)
        initialise(io.cpu)
        sensor.begin()
        background.tell_start()
        background.run()

    def spoil(self) -> None:
        """Leave an attitude that is none, as a defective kernel would."""
        if self._attitude is not None:
            self._attitude.spoil()

    def memory(self) -> bytes:
        """The attitude computer's state as it lies in memory."""
        return b"" if self._attitude is None else self._attitude.memory()


class AttitudeTasks:
    """Three samples make an iteration, some iterations an output."""

    def __init__(self, io: BoardIo, settings: Settings, attitude: Attitude, output: Output) -> None:
        self._cpu = io.cpu
        self._attitude = attitude
        self._output = output
        kind = settings.arithmetic
        self._cost = io.cpu.cost(f"iteration_{kind}")
        if settings.drift_compensation:
            self._cost += io.cpu.cost(f"drift_{kind}")
        self._iterations_per_output = settings.iterations_per_output
        self._iterations = 0
        self._output_line = io.interrupts.attach("output", output.send)
        self.line = io.interrupts.attach("attitude", self._on_samples)

    def _on_samples(self) -> None:
        made = self._attitude.iterate()
        if made == SPOILT:
            self._output.note_spoilt()
        self._cpu.spend(self._cost)
        self._iterations += 1
        if self._iterations == self._iterations_per_output:
            self._iterations = 0
            self._output_line.pend()
