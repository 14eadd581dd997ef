"""The Earth's field and what a compass feels; an HMC6343 on a described board finds the heading."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pygeomag import GeoMag
from scipy.spatial.transform import Rotation

from boards.assembly import assemble
from boards.description import load_board
from boards.validation import DescriptionError
from firmware.drivers import hmc6343_sample as sample
from firmware.drivers.hmc6343 import Hmc6343, Hmc6343Config, Outcome
from host.run.surroundings import Surroundings
from host.sim.scenario.load import scenario_from
from host.sim.world import World

SECOND = 1_000_000_000
LEVEL = np.diag([1.0, -1.0, -1.0])
"""C_b_s: x forward, y left, z up."""


def model_field(latitude: float, longitude: float, height: float) -> np.ndarray:
    """North, east, down in T on the day on which scenarios begin, by pygeomag itself."""
    found = GeoMag(coefficients_file="wmm/WMM_2020.COF").calculate(
        glat=latitude, glon=longitude, alt=height / 1000.0, time=2024.0 + 134.3 / 366.0
    )
    return np.array([found.x, found.y, found.z]) * 1e-9


def world(duration_s: float = 60.0, **changes: Any) -> World:
    data: dict[str, Any] = {
        "place": {"latitude_deg": 47.0, "longitude_deg": 8.0, "height_m": 400.0, "geoid_separation_m": 0.0},
        "duration_s": duration_s,
        "segment": [{"kind": "rest", "duration_s": duration_s}],
        **changes,
    }
    return World(scenario_from(data, "standing", "test"), 1)


def test_force_and_field_at_rest() -> None:
    initial = {"yaw_deg": 70.0, "pitch_deg": 10.0, "roll_deg": -20.0}
    felt = world(initial=initial).compass("U5", LEVEL)
    values = felt.sample(np.arange(1, 401) * SECOND // 10)
    c_nb = Rotation.from_euler("ZYX", [70.0, 10.0, -20.0], degrees=True).as_matrix()
    c_ns = c_nb @ LEVEL
    field = model_field(47.0, 8.0, 400.0)
    mean = values.mean(axis=0)
    assert mean[:3] == pytest.approx(c_ns.T @ [0.0, 0.0, -9.807], abs=0.01)
    assert mean[3:6] == pytest.approx(c_ns.T @ field, abs=3e-8)
    assert values[:, 3].std() == pytest.approx(1e-7, rel=0.2)
    assert values[:, 0].std() == pytest.approx(9.81 * math.radians(0.2), rel=0.2)
    assert (values[:, 6] == 25.0).all()


def test_the_vehicles_iron_bends_the_field() -> None:
    soft = [[1.1, 0.05, 0.0], [0.05, 0.9, -0.02], [0.0, 0.03, 1.0]]
    iron = {"hard_iron_ut": [6.0, -9.0, 4.0], "soft_iron": soft, "noise_ut": 0.5}
    initial = {"yaw_deg": 200.0, "pitch_deg": -4.0, "roll_deg": 7.0}
    values = (
        world(initial=initial, magnetometer=iron)
        .compass("U5", LEVEL)
        .sample(np.arange(1, 2001) * SECOND // 40)
    )
    c_nb = Rotation.from_euler("ZYX", [200.0, -4.0, 7.0], degrees=True).as_matrix()
    on_board = np.array(soft) @ (c_nb.T @ model_field(47.0, 8.0, 400.0)) + 1e-6 * np.array([6.0, -9.0, 4.0])
    assert values[:, 3:6].mean(axis=0) == pytest.approx(LEVEL.T @ on_board, abs=6e-8)
    assert values[:, 3:6].std(axis=0) == pytest.approx([math.hypot(0.5e-6, 1e-7)] * 3, rel=0.06)


def test_force_of_a_drive_is_that_of_the_inertial_sensor() -> None:
    drive = [
        {"kind": "reach-speed", "duration_s": 10.0, "to_mps": 15.0},
        {"kind": "turn", "duration_s": 20.0, "angle_deg": 180.0},
    ]
    moving = world(30.0, segment=drive, imu={"preset": "perfect"})
    times = np.arange(1, 291) * SECOND // 10
    felt = moving.compass("U5", LEVEL).sample(times)[:, :3]
    true = moving.imu("U1", LEVEL).sample(times, 50.0)[:, :3]
    assert (felt - true).std(axis=0) == pytest.approx([0.034] * 3, rel=0.2)
    assert np.abs((felt - true).mean(axis=0)).max() < 0.01


def test_same_seed_same_values() -> None:
    times = np.arange(1, 20) * SECOND
    first, second = (world().compass("U5", LEVEL).sample(times) for _ in range(2))
    assert (first == second).all()
    assert (world().compass("U6", LEVEL).sample(times) != first).any()


BOARD = """
name = "compass"
title = "an HMC6343"
default_profile = "plain"
default_scenario = "none"
[processors.mcu]
part = "STM32F405"
clock_hz = 168_000_000
program = "test_compass_world:program"
tasks = { tick = { priority = 2 } }
[buses.i2c1]
kind = "i2c"
processor = "mcu"
clock_hz = 100_000
[chips.U5]
part = "HMC6343"
model = "boards.chips.hmc6343:Hmc6343"
bus = "i2c1"
name = "compass"
world = "compass"
mounting = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]]
parameters = { strict = true }
[profiles.plain]
"""


class Reads:
    """Five headings a second."""

    def __init__(self, io: Any) -> None:
        self.io = io
        self.chip = Hmc6343(io.i2c["i2c1"], io.cpu, Hmc6343Config())
        self.outcome: Outcome | None = None
        self.angles: list[Any] = []

    def main(self) -> None:
        self.outcome = self.chip.start()
        angles = np.zeros(sample.ANGLES_SIZE, np.float32)
        while True:
            self.io.cpu.delay(200_000_000)
            if self.chip.read():
                sample.convert(self.chip.raw, angles)
                self.angles.append(np.degrees(angles))

    def spoil(self) -> None:
        """Nothing to spoil."""

    def memory(self) -> bytes:
        return b""


def program(io: Any, _profile: Any, _installation: Any) -> Reads:
    return Reads(io)


def test_a_compass_in_another_world_is_refused(tmp_path: Path) -> None:
    (tmp_path / "compass").mkdir()
    text = BOARD.replace('world = "compass"', 'world = "imu"')
    (tmp_path / "compass" / "board.toml").write_text(text)
    with pytest.raises(DescriptionError, match=r'chips\.U5\.world = "imu": a HMC6343 feels "compass"'):
        assemble(load_board(str(tmp_path / "compass")), {}, Surroundings(world(), None))


def test_a_compass_on_a_board_finds_the_heading(tmp_path: Path) -> None:
    (tmp_path / "compass").mkdir()
    (tmp_path / "compass" / "board.toml").write_text(BOARD)
    initial = {"yaw_deg": 250.0, "pitch_deg": 5.0, "roll_deg": -10.0}
    surroundings = Surroundings(world(initial=initial), None)
    board = assemble(load_board(str(tmp_path / "compass")), {}, surroundings)
    board.machine.run_until(30 * SECOND)
    program = board.programs["mcu"]
    board.machine.power_off()
    assert isinstance(program, Reads)
    assert program.outcome is Outcome.OK
    north, east, _ = model_field(47.0, 8.0, 400.0)
    declination = math.degrees(math.atan2(east, north))
    assert len(program.angles) > 100
    mean = np.mean(program.angles, axis=0)
    assert mean == pytest.approx([250.0 - declination, 5.0, -10.0], abs=0.15)
    assert np.std(program.angles, axis=0) == pytest.approx([0.5, 0.2, 0.2], abs=0.25)
    assert board.chips["U5"].reports == []
