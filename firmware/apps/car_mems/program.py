"""The program of the STM32F405: interrupts, tasks and the background loop.

imu_ready / imu_timer ─► navigation ─► output (10 Hz)
USART3 DMA, idle line ─► gnss_receive ─► filter
timepulse                                            main: configuration, log, health, watchdog
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from firmware.apps.car_mems.acquisition import Acquisition
from firmware.apps.car_mems.background import Background
from firmware.apps.car_mems.gnss_port import GnssPort
from firmware.apps.car_mems.navigation import Navigation, NavigationKernels, nav_config
from firmware.apps.car_mems.raw_loop import RawLoop
from firmware.apps.car_mems.raw_output import ToldNavigation, check_baud
from firmware.apps.car_mems.settings import Settings
from firmware.apps.gnss_ins.announcements import Announcer
from firmware.apps.gnss_ins.output import Output
from hal.board_io import BoardIo
from hal.machine_code import mypyc_attr


def program(io: BoardIo, profile: Mapping[str, Any], installation: Mapping[str, Any]) -> CarMems:
    """The image in flash. Raises ValueError for a profile that no program could mean."""
    return CarMems(io, Settings.of(profile), installation)


def raw_loop(
    profile: Mapping[str, Any], installation: Mapping[str, Any], captures: Collection[str]
) -> RawLoop:
    """The same navigation without a board, for raw frames; `captures`: pins wired to capture timers."""
    return RawLoop(profile, installation, captures)


@mypyc_attr(allow_interpreted_subclasses=True)
class CarMems:
    """Implements `hal.board_io.Program`."""

    def __init__(self, io: BoardIo, settings: Settings, installation: Mapping[str, Any]) -> None:
        self._io = io
        self._settings = settings
        self._kernels = NavigationKernels(settings.precision)
        if settings.raw_output:
            check_baud(settings, io.uart["host"].baud)
        self._config = nav_config(settings, installation, "timepulse" in io.captures)
        self._navigation: Navigation | None = None

    def main(self) -> None:
        """From the reset vector: nothing survives a reset."""
        io, settings = self._io, self._settings
        told = ToldNavigation(self._kernels, self._config, io, settings) if settings.raw_output else None
        navigation = Navigation(self._kernels, self._config) if told is None else told
        self._navigation = navigation
        gnss = GnssPort(io, settings, navigation)
        acquisition = Acquisition(io, settings)
        output = Output(
            io,
            navigation,
            gnss,
            acquisition,
            port=io.uart["host"],
            clock=io.clock,
            task_frames=settings.task_frames,
        )
        gnss.updated = output.send_epoch
        tasks = NavigationTasks(io, settings, navigation, acquisition, output)
        announcer = Announcer(io.clock, gnss, output)
        background = Background(io, navigation, gnss, acquisition, output, announcer)
        if told is not None:
            told.begin(output.look, output.tell, lambda: gnss.epoch)
        gnss.begin()
        tasks.begin()
        background.run()

    def spoil(self) -> None:
        """Leave NaN in the velocity, as a defective kernel would."""
        if self._navigation is not None:
            self._navigation.spoil()

    def memory(self) -> bytes:
        """The navigation state as it lies in memory."""
        if self._navigation is None:
            return b""
        return self._navigation.memory()


@mypyc_attr(allow_interpreted_subclasses=True)
class NavigationTasks:
    """The chain from a sample to the state: reads make steps, steps make outputs."""

    def __init__(
        self,
        io: BoardIo,
        settings: Settings,
        navigation: Navigation,
        acquisition: Acquisition,
        output: Output,
    ) -> None:
        self._cpu = io.cpu
        self._acquisition = acquisition
        self._raw = acquisition.chip.raw
        self._f = navigation.f
        self._i = navigation.i
        mean = settings.strapdown == "mean"
        self._step = navigation.sample_step(mean)
        self._step_cost = io.cpu.cost("navigation_mean" if mean else "navigation_step")
        self._sample_cost = io.cpu.cost("convert_average")
        self._steps_per_output = settings.steps_per_output
        self._steps = 0
        self._output_line = io.interrupts.attach("output", output.send)
        line = io.interrupts.attach("navigation", self._on_mean_sample if mean else self._on_sample)
        acquisition.sample_task = line

    def begin(self) -> None:
        """Let samples come."""
        self._acquisition.begin()

    def _on_sample(self) -> None:
        """`full-rate`: a step for every sample."""
        step = self._step
        step(self._f, self._i, self._raw, self._acquisition.read_at_ns)
        self._cpu.spend(self._step_cost)
        self._steps = steps = self._steps + 1
        if steps == self._steps_per_output:
            self._steps = 0
            self._output_line.pend()

    def _on_mean_sample(self) -> None:
        """`thesis`: a step for every tenth sample."""
        self._cpu.spend(self._sample_cost)
        if self._step(self._f, self._i, self._raw, self._acquisition.read_at_ns):
            self._cpu.spend(self._step_cost)
            self._steps += 1
            if self._steps == self._steps_per_output:
                self._steps = 0
                self._output_line.pend()
