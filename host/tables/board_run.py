"""The board on the rotary table: chip, bus, processor and firmware, through one motion.

The sensor is as it is after its auto-null on a levelled table: no turn-on bias, but noise, misalignment and a
gyro bias that wanders by 0.007 °/s (1 σ, the sheet's in-run bias). The heading at the start is the table's.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from boards.description import load_board
from hal.emulated.virtual_time import SECOND
from host.record.result import RunRequest
from host.run.runner import run_in_world
from host.run.session import manifest_of
from host.run.setup import Setup
from host.sim.scenario.schema import Scenario
from host.sim.world import World
from host.tables.positions import PLACE

Array = NDArray[np.float64]

BOARD = "uav_ahrs"
STILL_S = 7.0
"""Start-up, self-test, alignment."""
SETTINGS: dict[str, Any] = {
    "latitude_deg": PLACE["latitude_deg"],
    "longitude_deg": PLACE["longitude_deg"],
    "height_m": PLACE["height_m"],
    "initial_yaw_deg": 0.0,
    "magnetometer": False,
    "output_rate_hz": 25,
}


def sensor() -> dict[str, Any]:
    """The table `imu` of a scenario: what the preset of the chip says, but nulled."""
    return {"gyro": {"turn_on_bias_dps": 0.0}, "accelerometer": {"turn_on_bias_mg": 0.0}}


@dataclass(frozen=True, slots=True)
class Told:
    """What the board told: solutions and the truth at their times, (n, 3) pitch, roll, yaw in rad."""

    times_s: Array
    measured: Array
    truth: Array

    def after(self, begin_s: float) -> Told:
        """The part behind a time."""
        kept = self.times_s > begin_s
        return Told(self.times_s[kept], self.measured[kept], self.truth[kept])


def run_board(scenario: Scenario, arithmetic: str, seed: int, **settings: Any) -> Told:
    """One run of the profile `arithmetic`; `settings` go before SETTINGS. Raises UserError."""
    board = load_board(BOARD)
    profile = {**board.profiles[arithmetic], **SETTINGS, **settings}
    setup = Setup(board, scenario, arithmetic, profile)
    request = RunRequest(BOARD, seed=seed, profile=arithmetic, capture=False)
    world = World(scenario, seed)
    result = run_in_world(request, setup, world, manifest_of(request, setup))
    assert result.data is not None
    series = result.data.solution
    times_s = series.column("t_s")
    truth = world.another().truth(np.round(times_s * SECOND).astype(np.int64))
    told = [np.radians(series.column(f"{name}_deg")) for name in ("pitch", "roll", "yaw")]
    return Told(times_s, np.column_stack(told), np.column_stack((truth.pitch, truth.roll, truth.yaw)))
