"""What the host knew of a captured run while it was on: its world, its receiver, where its sensors sit."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from boards.description import Board
from hal.emulated.virtual_time import FAR
from host.recovery.receiver_times import ReceiverTimes
from host.replay.setting import recorded_board, recorded_scenario
from host.run.faults import begun, name_of
from host.run.intake import HOST_PORT, Truths
from host.run.surroundings import Installation, Surroundings
from host.sim.gnss.faults import GNSS_FAULT_KINDS, glitches_of
from host.sim.gnss.schedule import Glitch, Window
from host.sim.scenario.errors import ScenarioError
from host.sim.scenario.schema import Fault
from host.sim.truth import TruthBatch, unknown_bias
from host.sim.world import World

Floats = NDArray[np.float64]
WORLD_OF_SENSORS = ("imu", "ten_dof")


class RecordedRun:
    """Made of the manifest and of what was done from outside.

    Raises UserError, DescriptionError or ScenarioError when the manifest makes no sense here.
    """

    def __init__(self, manifest: Mapping[str, Any], commands: Iterable[Mapping[str, Any]]) -> None:
        self.board: Board = recorded_board(manifest)
        self.processor = self.board.uarts[HOST_PORT].processor
        self.installation = Installation.of(self.board)
        self.truth: Truths = UnknownTruth()
        self.without_truth: str | None = None
        """Why errors cannot be told; None: they can."""
        self.receiver: ReceiverTimes | None = None
        if "replay_of" in manifest:
            self.without_truth = "the road of a physical replay stands in the capture that was replayed"
            return
        scenario, seed = recorded_scenario(manifest), int(manifest["seed"])
        try:
            world = World(scenario, seed)
            undisturbed = World(scenario.model_copy(update={"fault": []}), seed)
        except ScenarioError as error:
            self.without_truth = str(error)
            return
        commands = list(commands)
        self._sense(world)
        self.truth = world
        _put_down(world, commands)
        refdes = next((r for r, chip in self.board.chips.items() if chip.world == "gnss"), None)
        if refdes is not None and refdes not in manifest.get("stand_ins", {}):
            glitches = glitches_of(scenario.fault, refdes, world.duration_ns, seed)
            glitches += _injected(commands, refdes, seed)
            surroundings = Surroundings(undisturbed, None)
            at_zero = surroundings.gnss(refdes, self.board.chips[refdes]).epoch(0)
            self.receiver = ReceiverTimes(at_zero, glitches)

    def _sense(self, world: World) -> None:
        """Have the sensors whose true biases will be asked for."""
        surroundings = Surroundings(world, None)
        for refdes, chip in self.board.chips.items():
            if chip.world in WORLD_OF_SENSORS:
                getattr(surroundings, chip.world)(refdes, chip)


class UnknownTruth:
    """Implements `host.run.intake.Truths` where nobody knows."""

    def truth(self, times_ns: NDArray[np.int64]) -> TruthBatch:
        """Nothing at the vehicle's origin."""
        nothing = np.full(len(times_ns), np.nan)
        none = unknown_bias(len(times_ns))
        return TruthBatch(times_ns, *(nothing,) * 3, none, *(nothing,) * 3, none, none)

    def antenna_truth(self, times_ns: NDArray[np.int64], _lever_arm: Floats) -> TruthBatch:
        """Nothing at a point of the body."""
        return self.truth(times_ns)


def _put_down(world: World, commands: Iterable[Mapping[str, Any]]) -> None:
    for command in commands:
        if command["command"] == "position":
            latitude, longitude = np.radians((command["latitude_deg"], command["longitude_deg"])).tolist()
            world.put_down(command["time_ns"], latitude, longitude, command["height_m"])


def _injected(commands: Iterable[Mapping[str, Any]], receiver: str, seed: int) -> list[Glitch]:
    """Faults of the receiver's own solution that came over the control channel."""
    found: dict[str, Glitch] = {}
    for command in commands:
        if command["command"] == "inject":
            fault = Fault.model_validate(command["fault"])
            if fault.kind in GNSS_FAULT_KINDS and fault.target == receiver:
                found[name_of(fault)] = begun(fault, command["time_ns"], seed)
        elif command["command"] == "clear" and command["name"] in found:
            glitch = found[command["name"]]
            glitch.window = Window(glitch.window.start_ns, min(command["time_ns"], FAR))
    return list(found.values())
