"""Scores of a board without a receiver: every solution counts, from the end of the alignment on."""

from __future__ import annotations

import numpy as np
import pytest

from host.record.run_data import MotionBatch, SolutionBatch
from host.score.rules import ScoringRules
from host.score.scorer import Score, Scorer


def motion(t: np.ndarray, roll: np.ndarray | float = 0.0) -> dict[str, np.ndarray]:
    n = len(t)
    zero = np.zeros(n)
    return {
        "t": t, "latitude": zero + 0.7, "longitude": zero + 1.9, "height": zero + 1000.0,
        "velocity_ned": np.zeros((n, 3)), "yaw": zero, "pitch": zero, "roll": zero + roll,
    }  # fmt: skip


def score(mode: np.ndarray, roll: np.ndarray, rules: ScoringRules) -> Score:
    t = np.arange(1, len(mode) + 1) / 10.0
    unknown = np.full((len(t), 3), np.nan)
    solution = SolutionBatch(
        **motion(t, roll),
        sigma_position=unknown,
        sigma_velocity=unknown,
        sigma_attitude=unknown,
        mode=mode,
        flags=np.zeros(len(t), np.int64),
    )
    scorer = Scorer(rules)
    scorer.add_solution(solution, MotionBatch(**motion(t)))
    return scorer.result(t[-1])


ALONE = ScoringRules(at_receiver_epochs=False)


def test_all_navigation_solutions_count_and_no_others() -> None:
    mode = np.array([1] * 50 + [3] * 100)
    roll = np.radians(np.where(mode == 1, 90.0, 0.5))
    metrics = score(mode, roll, ALONE).metrics
    assert metrics["roll_rms_deg"] == pytest.approx(0.5)
    assert metrics["roll_max_deg"] == pytest.approx(0.5)
    assert metrics["epochs"] == 100
    assert metrics["epochs_without_solution"] == 0
    assert metrics["aligned_at_s"] == pytest.approx(5.1)


def test_solutions_lost_after_the_alignment_are_counted() -> None:
    mode = np.array([1] * 10 + [3] * 40 + [0] * 20 + [4] * 30)
    metrics = score(mode, np.zeros(100), ALONE).metrics
    assert metrics["epochs"] == 90
    assert metrics["epochs_without_solution"] == 20


def test_a_board_with_a_receiver_is_scored_at_its_epochs_alone() -> None:
    metrics = score(np.full(100, 3), np.zeros(100), ScoringRules()).metrics
    assert metrics["roll_rms_deg"] is None
    assert metrics["epochs"] == 0
