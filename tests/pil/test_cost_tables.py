"""What the emulated processor is charged is what was counted on an emulated Cortex-M4F."""

import json
import math
import tomllib
from pathlib import Path

import pytest
from pil_tools import needs_processor

import boards
from boards.description import load_board
from host.cli.pil_run import Asked, execute
from host.record.result import RunRequest

FOLDER = Path(boards.__path__[0]) / "car_mems"
MEASURED = tomllib.loads((FOLDER / "measured.toml").read_text(encoding="utf-8"))


def test_lines_of_the_cost_table_are_counted_instructions():
    costs = load_board("car_mems").processors["mcu"].costs
    for line, kernels in MEASURED["lines"].items():
        counted = sum(MEASURED["instructions"][kernel][figure] for kernel, figure in kernels.items())
        unit = 1 if line == "parse_byte" else 10
        cycles = counted * MEASURED["cycles_per_instruction"]
        assert costs[line] == math.ceil(round(cycles, 6) / unit) * unit, line


def test_strapdown_and_prediction_of_15_states_stay_below_50_000_instructions():
    assert MEASURED["parts"]["strapdown and prediction of 15 states with their process noise"] < 50_000


@pytest.mark.soak
@needs_processor
def test_the_counts_are_those_of_the_present_sources(tmp_path):
    """Within 10 %: the mean of a step depends on what the drive asks for."""
    figures = tmp_path / "costs.json"
    request = RunRequest("car_mems", "static", "full-rate")
    assert execute(Asked(request, 9_000, None, True, False, None), str(figures), quiet=True) == 0
    found = json.loads(figures.read_text())
    for name, counted in MEASURED["instructions"].items():
        if name in found["cycles"]:
            assert found["cycles"][name]["most"] == pytest.approx(counted["most"], rel=0.1), name
    for name, counted in MEASURED["parts"].items():
        assert found["parts"][name] == pytest.approx(counted, rel=0.1), name
    steps = found["cycles"]["firmware.apps.car_mems.steps.data_ready_step"]
    assert steps["mean"] == pytest.approx(2772, rel=0.15)
