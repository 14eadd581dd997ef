"""Processor load and deadlines are part of the result, and too much work shows."""

from __future__ import annotations

from short_drive import drive

CUT = "duration_s=40"


def test_load_is_told_for_every_task_and_no_deadline_is_missed() -> None:
    (cpu,) = drive(CUT).result.cpu
    tasks = {task.name: task for task in cpu.tasks}
    assert cpu.deadline_misses == cpu.overruns == 0
    assert 100 * 3_890 / 168e6 < cpu.load < 0.1  # the steps alone
    assert tasks["navigation"].activations > 3900
    assert tasks["navigation"].worst_response_us < tasks["navigation"].deadline_us


def test_a_step_longer_than_its_period_misses_deadlines() -> None:
    (cpu,) = drive(CUT, "board.processors.mcu.costs.navigation_step=2000000").result.cpu
    tasks = {task.name: task for task in cpu.tasks}
    assert cpu.load > 0.9
    assert tasks["navigation"].deadline_misses > 1000
    assert tasks["navigation"].overruns > 300
    assert cpu.deadline_misses >= tasks["navigation"].deadline_misses
