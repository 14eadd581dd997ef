"""Accuracy on the scenarios of the board, one seed each; many seeds run in tests/soak."""

from __future__ import annotations

import functools

import numpy as np
import pytest

from host.record.result import RunRequest, RunResult
from host.run.runner import run


@functools.cache
def _run(scenario: str, *overrides: str) -> RunResult:
    return run(RunRequest("car_mems", scenario, overrides=overrides))


def test_town_open_meets_its_limits() -> None:
    result = _run("town-open")
    metrics, gnss = result.metrics, result.gnss
    assert metrics["position_horizontal_rms_m"] < gnss["position_horizontal_rms_m"]
    assert metrics["velocity_rms_mps"] <= 0.1
    assert max(metrics["roll_rms_deg"], metrics["pitch_rms_deg"]) <= 0.5
    assert metrics["yaw_rms_deg"] <= 1.5
    assert 4.5 <= metrics["nees_mean"] <= 18.0
    assert result.cpu[0].deadline_misses == 0


def test_time_tags_are_told_with_and_without_the_time_pulse() -> None:
    wired = _run("town-open").gnss
    free = _run("town-open", "board.pins.timepulse.wired=false").gnss
    assert abs(wired["time_tag_error_rms_s"]) < 0.002
    assert 0.002 < abs(free["time_tag_error_rms_s"]) < 0.06
    assert wired["time_tag_position_effect_rms_m"] < free["time_tag_position_effect_rms_m"]


@pytest.mark.soak  # compiling everything in float64 takes a minute
def test_float32_is_as_good_as_float64() -> None:
    single, double = _run("town"), _run("town", 'profile.precision="float64"')
    assert single.data is not None
    assert double.data is not None
    for name, limit in (
        ("error_north_m", 0.05), ("error_east_m", 0.05), ("error_down_m", 0.05),
        ("error_roll_deg", 0.05), ("error_pitch_deg", 0.05), ("error_yaw_deg", 0.05),
    ):  # fmt: skip
        a, b = single.data.solution.column(name), double.data.solution.column(name)
        late = single.data.solution.column("t_s") > 140.0
        apart = np.abs(a[late] - b[late])
        if "yaw" in name:
            apart = np.minimum(apart, 360.0 - apart)
        assert apart.max() <= limit, name


@pytest.mark.recording
def test_real_drive_beats_its_receiver() -> None:
    import os

    if not os.environ.get("NAVTWIN_DATA"):
        pytest.skip("needs NAVTWIN_DATA")
    result = _run("real-drive")
    assert result.metrics["position_horizontal_rms_m"] <= result.gnss["position_horizontal_rms_m"]
    assert result.recording is not None
    fused, receiver = (
        result.recording[one]["after_position_horizontal_rms_m"] for one in ("fused", "gnss")
    )  # time shift and offset fitted for each
    assert fused <= receiver
    cuts = [outage.horizontal_drift_m for outage in _run("real-drive-cuts").outages]
    assert len(cuts) == 4
    assert max(cuts) <= 5.0
