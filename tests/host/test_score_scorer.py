"""The scorer on drives whose figures are known beforehand."""

import numpy as np
import pytest
from synthetic_drive import Errors, gnss, motion, solution, times

from host.score.rules import ScoringRules
from host.score.scorer import Scorer


def run(scorer, end=200.0, fused=None, receiver=None, fix=True, batch=10.0, rate=10.0, start=0.0, late=0.0):
    """Feed a drive in batches, receiver epochs `late` s after the solutions. Errors: constant, or f(t)."""
    constant = Errors()
    fused, receiver = fused or constant, receiver or constant
    fused_at = fused if callable(fused) else lambda t: fused
    receiver_at = receiver if callable(receiver) else lambda t: receiver
    fix_at = fix if callable(fix) else lambda t: np.full(len(t), fix)
    epochs = times(0.0, end, 1.0)
    for begin in np.arange(start, end + batch, batch):
        t = times(begin, min(begin + batch, end), rate)
        heard = epochs[(epochs >= begin - late) & (epochs < begin + batch - late)]
        scorer.add_gnss(gnss(heard, receiver_at(heard), fix_at(heard)), motion(heard))
        if len(t):
            scorer.add_solution(solution(t, fused_at(t)), motion(t))
    return scorer.result(end)


def known(figures):
    return {name: value for name, value in figures.items() if value is not None}


def test_constant_errors_are_their_own_rms_max_and_p95():
    score = run(
        Scorer(),
        fused=Errors((0.3, 0.4, -1.0), (0.0, 0.03, 0.04), (0.02, 0.0, -0.01)),
        receiver=Errors((3, 4, 2)),
    )
    for figure in ("rms", "max", "p95"):
        assert score.metrics[f"position_horizontal_{figure}_m"] == pytest.approx(0.5, rel=3e-3)
        assert score.metrics[f"position_vertical_{figure}_m"] == pytest.approx(1.0, rel=3e-3)
        assert score.metrics[f"velocity_{figure}_mps"] == pytest.approx(0.05, rel=3e-3)
        assert score.metrics[f"velocity_horizontal_{figure}_mps"] == pytest.approx(0.03, rel=3e-3)
        assert score.metrics[f"yaw_{figure}_deg"] == pytest.approx(np.degrees(0.02), rel=3e-3)
        assert score.metrics[f"roll_{figure}_deg"] == pytest.approx(np.degrees(0.01), rel=3e-3)
        assert score.metrics[f"pitch_{figure}_deg"] == pytest.approx(0.0, abs=1e-4)
        assert score.gnss[f"position_horizontal_{figure}_m"] == pytest.approx(5.0, rel=3e-3)


def test_both_are_scored_on_the_same_epochs_from_a_minute_after_alignment():
    score = run(Scorer(), end=200)
    assert score.metrics["aligned_at_s"] == 0.0
    assert score.metrics["epochs"] == score.gnss["epochs"] == 140
    assert score.metrics["availability"] == 1.0


def test_the_solution_is_taken_at_the_receivers_own_instant():
    """An error that grows as t is found exactly at the epochs, which fall between the solutions."""

    def growing(t):
        return Errors(position=np.stack((t, 0 * t, 0 * t), axis=1))

    score = run(Scorer(ScoringRules(0, 0)), end=20, fused=growing, start=0.05)
    epochs = np.arange(1, 20)
    assert score.metrics["position_horizontal_max_m"] == pytest.approx(19.0, abs=1e-4)
    assert score.metrics["position_horizontal_rms_m"] == pytest.approx(
        np.sqrt(np.mean(epochs**2.0)), rel=1e-4
    )


def test_epochs_after_a_tunnel_wait_ten_seconds_and_tunnels_count_as_outages_only():
    def fused(t):
        inside = (t > 120) & (t <= 150)
        east = np.where(inside, (t - 120) * 0.5, 0.25)
        return Errors(position=np.stack((0 * t, east, 0 * t), axis=1))

    scorer = Scorer(outages=[(120.0, 30.0)])
    score = run(scorer, end=200, fused=fused, fix=lambda t: (t <= 120) | (t > 150))
    assert score.metrics["position_horizontal_max_m"] == pytest.approx(0.25, rel=1e-4)
    assert score.metrics["epochs"] == (120 - 60 + 1) + (199 - 161 + 1)
    assert score.gnss["fix_share"] == pytest.approx(170 / 200)
    (outage,) = score.outages
    assert (outage.start_s, outage.duration_s) == (120.0, 30.0)
    assert outage.horizontal_drift_m == pytest.approx(15.0, rel=1e-4)
    assert outage.horizontal_error_at_start_m == pytest.approx(0.25, rel=1e-3)
    assert score.metrics["outage_horizontal_drift_median_m"] == pytest.approx(15.0, rel=1e-4)
    assert score.metrics["continuous_position_horizontal_max_m"] == pytest.approx(15.0, rel=1e-4)


@pytest.mark.parametrize("fix", [True, False])
def test_one_missing_second_is_not_a_reacquisition_but_a_lost_fix_is(fix):
    def fixes(t):
        return t != 100 if not fix else np.full(len(t), True)

    score = run(Scorer(), end=200, fix=fixes)
    assert score.metrics["epochs"] == (140 if fix else 140 - 11)


def test_receiver_epochs_that_arrive_late_are_scored_the_same():
    errors = {"fused": Errors((0.3, 0.4, 0)), "receiver": Errors((1, 0, 0))}
    late, early = run(Scorer(), late=1.0, **errors), run(Scorer(), **errors)
    assert known(late.metrics) == pytest.approx(known(early.metrics))
    assert late.gnss == pytest.approx(early.gnss)


@pytest.mark.parametrize("batch", [0.5, 7.0, 100.0])
def test_batch_size_changes_nothing(batch):
    rng = np.random.default_rng(3)
    noise = rng.normal(0, 1, (4000, 3))

    def noisy(t):
        return Errors(position=noise[np.round(t * 10).astype(int)])

    reference, score = run(Scorer(), fused=noisy), run(Scorer(), fused=noisy, batch=batch)
    assert known(score.metrics) == pytest.approx(known(reference.metrics), rel=1e-9)


def test_a_board_that_falls_silent_is_not_available():
    scorer = Scorer()
    t = times(0, 100, 10)
    scorer.add_gnss(gnss(times(0, 200, 1)), motion(times(0, 200, 1)))
    scorer.add_solution(solution(t), motion(t))
    score = scorer.result(200.0)
    assert score.metrics["availability"] == pytest.approx(0.5)
    assert score.metrics["epochs_without_solution"] == 99


def test_not_a_number_and_alignment_modes_are_no_solution():
    scorer = Scorer(ScoringRules(0, 0))
    t = times(0, 30, 10)
    broken = solution(t)
    broken.velocity_ned[150:200] = np.nan
    broken.mode[200:] = 1
    scorer.add_gnss(gnss(times(0, 30, 1)), motion(times(0, 30, 1)))
    scorer.add_solution(broken, motion(t))
    score = scorer.result(30.0)
    assert score.metrics["epochs_without_solution"] == 15
    assert score.metrics["availability"] == pytest.approx(0.5)


def test_without_any_solution_there_is_no_figure():
    score = Scorer(outages=[(10, 20)]).result(60.0)
    assert score.metrics["position_horizontal_rms_m"] is None
    assert score.metrics["availability"] == 0.0
    assert score.outages[0].horizontal_drift_m is None
    assert score.metrics["outage_horizontal_drift_max_m"] is None


def test_solutions_that_step_back_in_time_are_left_out_and_counted():
    scorer = Scorer()
    t = np.array([1.0, 1.1, 1.1, 1.0, 1.2])
    scorer.add_solution(solution(t), motion(t))
    scorer.add_solution(solution(t[:1]), motion(t[:1]))
    assert scorer.result(2.0).metrics["solutions_out_of_order"] == 3


def test_receiver_without_vertical_velocity_has_horizontal_figures_only():
    scorer = Scorer(ScoringRules(0, 0))
    t = times(0, 20, 1)
    report = gnss(t, Errors(velocity=(0.3, 0.4, 0)))
    report.velocity_ned[:, 2] = np.nan
    scorer.add_gnss(report, motion(t))
    scorer.add_solution(solution(times(0, 20, 10)), motion(times(0, 20, 10)))
    score = scorer.result(20.0)
    assert score.gnss["velocity_rms_mps"] is None
    assert score.gnss["velocity_horizontal_rms_mps"] == pytest.approx(0.5, rel=1e-4)


def test_memory_of_a_long_run_stays_flat():
    scorer = Scorer()
    for begin in range(0, 4000, 10):
        t, epochs = times(begin, begin + 10, 10), times(begin, begin + 10, 1)
        scorer.add_gnss(gnss(epochs), motion(epochs))
        scorer.add_solution(solution(t), motion(t))
        scorer.add_covariance(float(begin), np.eye(9))
    assert scorer.buffered_rows < 300
