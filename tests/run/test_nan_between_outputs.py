"""A state that breaks while no sample comes that would show it: no number is told, and nothing crashes."""

from __future__ import annotations

from host.record.result import RunRequest
from host.run.runner import run


def test_a_state_that_breaks_while_the_imu_is_off_is_no_fix():
    faults = '{kind="chip-off",target="U2",at_s=40,duration_s=6},{kind="nav-nan",target="mcu",at_s=42.4}'
    result = run(RunRequest("car_mems", "static", overrides=("duration_s=110", f"fault=[{faults}]")))
    assert all(fault.fired for fault in result.faults)
    assert result.metrics["seconds_with_solution"] > 50
