"""An ADIS16407 on a described board, read by our driver at every data ready, in a simulated world."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pygeomag import GeoMag
from scipy.spatial.transform import Rotation

from boards.assembly import assemble
from boards.description import load_board
from boards.validation import DescriptionError
from firmware.drivers import adis16407_sample as sample
from firmware.drivers.adis16407 import Adis16407, Adis16407Config, Outcome
from hal.pins import Edge
from host.run.surroundings import Surroundings
from host.sim.scenario.load import scenario_from
from host.sim.world import World

SECOND = 1_000_000_000
BOARD = """
name = "ten"
title = "an ADIS16407"
default_profile = "plain"
default_scenario = "none"
[processors.mcu]
part = "STM32F405"
clock_hz = 168_000_000
program = "test_adis16407_on_a_board:program"
tasks = { ready = { priority = 2 } }
[buses.spi1]
kind = "spi"
processor = "mcu"
clock_hz = 5_000_000
[chips.U1]
part = "ADIS16407"
model = "boards.chips.adis16407:Adis16407"
bus = "spi1"
name = "imu"
world = "ten_dof"
errors = "%ERRORS%"
mounting = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]]
spi = { clock_hz = 1_000_000, bits_per_word = 16, stall_clocks = 1, high_ns = 9_000 }
pins = { DIO1 = "U1_DIO1" }
parameters = { strict = %STRICT% }
[pins.ready]
processor = "mcu"
net = "U1_DIO1"
use = "input"
[profiles.plain]
"""


class Reads:
    """A burst at each data ready."""

    def __init__(self, io: Any) -> None:
        self.io = io
        self.chip = Adis16407(io.spi["imu"], io.cpu, Adis16407Config(filter=0))
        self.outcomes: list[Outcome] = []
        self.samples: list[Any] = []
        self.flags: set[int] = set()
        self.scale = self.chip.config.scales()

    def main(self) -> None:
        self.outcomes.append(self.chip.start())
        line = self.io.interrupts.attach("ready", self.on_data)
        self.io.inputs["ready"].interrupt_on(Edge.RISING, line)
        while True:
            self.io.cpu.delay(100_000_000)
            self.outcomes.append(self.chip.check())

    def on_data(self) -> None:
        values = np.zeros(sample.SAMPLE_SIZE, np.float32)
        self.chip.read()
        self.flags.add(sample.convert(self.chip.raw, self.scale, values))
        self.samples.append(values)

    def spoil(self) -> None:
        """Nothing to spoil."""

    def memory(self) -> bytes:
        return b""


def program(io: Any, _profile: Any, _installation: Any) -> Reads:
    return Reads(io)


def world() -> World:
    data: dict[str, Any] = {
        "place": {"latitude_deg": 47.0, "longitude_deg": 8.0, "height_m": 400.0, "geoid_separation_m": 0.0},
        "duration_s": 20.0,
        "initial": {"yaw_deg": 250.0, "pitch_deg": 5.0, "roll_deg": -10.0},
        "segment": [{"kind": "rest", "duration_s": 20.0}],
    }
    return World(scenario_from(data, "standing", "test"), 1)


def run(folder: Path, text: str, seconds: int) -> tuple[Reads, Any]:
    (folder / "ten").mkdir()
    (folder / "ten" / "board.toml").write_text(text)
    board = assemble(load_board(str(folder / "ten")), {}, Surroundings(world(), None))
    board.machine.run_until(seconds * SECOND)
    reads = board.programs["mcu"]
    board.machine.power_off()
    assert isinstance(reads, Reads)
    return reads, board.chips["U1"]


def test_every_sample_is_read_once_and_is_the_world(tmp_path: Path) -> None:
    """Strict: nothing that the driver does is outside the sheet. Every check of the background is disturbed
    by bursts of the interrupt."""
    reads, chip = run(tmp_path, BOARD.replace("%ERRORS%", "perfect").replace("%STRICT%", "true"), 4)
    assert chip.reports == []
    assert set(reads.outcomes) == {Outcome.OK}
    assert len(reads.outcomes) > 30
    assert reads.flags == {sample.NEW}
    assert len(reads.samples) == pytest.approx((4.0 - 0.445) * 819.2, abs=4)
    mean = np.mean(np.array(reads.samples, np.float64), axis=0)
    c_ns = Rotation.from_euler("ZYX", [250.0, 5.0, -10.0], degrees=True).as_matrix() @ np.diag([1, -1, -1])
    model = GeoMag(coefficients_file="wmm/WMM_2020.COF").calculate(
        glat=47.0, glon=8.0, alt=0.4, time=2024.367
    )
    field = np.array([model.x, model.y, model.z]) * 1e-9
    assert mean[3:6] == pytest.approx(c_ns.T @ [0.0, 0.0, -9.807], abs=0.02)
    assert mean[6:9] == pytest.approx(c_ns.T @ field, abs=2.6e-8)
    assert mean[9] == pytest.approx(96_611.0, abs=5.0)  # 400 m in tables of the standard atmosphere
    assert mean[11] == pytest.approx(5.0, abs=1.3e-3)


def test_noise_of_the_preset_is_that_of_the_sheet(tmp_path: Path) -> None:
    """Without the filter 0.8 °/s, 9 mg, 1.25 mgauss and 0.027 mbar rms."""
    reads, _ = run(tmp_path, BOARD.replace("%ERRORS%", "adis16407").replace("%STRICT%", "false"), 4)
    spread = np.std(np.array(reads.samples, np.float64), axis=0)
    assert np.degrees(spread[:3]) == pytest.approx([0.8] * 3, rel=0.07)
    assert spread[3:6] == pytest.approx([9e-3 * 9.80665] * 3, rel=0.07)
    assert spread[6:9] == pytest.approx([1.25e-7] * 3, rel=0.09)
    assert spread[9] == pytest.approx(2.7, rel=0.07)


def test_a_bus_without_pauses_is_told(tmp_path: Path) -> None:
    text = BOARD.replace("%ERRORS%", "perfect").replace("%STRICT%", "false")
    lines = [line for line in text.splitlines() if not line.startswith("spi =")]
    _, chip = run(tmp_path, "\n".join(lines), 1)
    details = {report.detail.split(":")[0] for report in chip.reports}
    assert details == {
        "clock faster than 2000 kHz", "clock faster than 1000 kHz", "pause between words too short",
    }  # fmt: skip


def test_another_world_is_refused(tmp_path: Path) -> None:
    text = BOARD.replace("%ERRORS%", "perfect").replace("%STRICT%", "true").replace('"ten_dof"', '"imu"')
    with pytest.raises(DescriptionError, match=r'chips\.U1\.world = "imu": a ADIS16407 feels "ten_dof"'):
        run(tmp_path, text, 1)
