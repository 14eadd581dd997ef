"""Intervals and bounds against published tables, and against what they promise."""

from __future__ import annotations

import numpy as np
import pytest

from host.campaign.plan import Setup
from host.campaign.statistics import figures, mean_interval, mean_square_bounds, nan_mean, spread
from host.campaign.summary import SetupSummary, Summary
from host.campaign.swept_value import swept_value
from host.campaign.tables import sections


def test_student_interval_of_a_textbook_sample() -> None:
    """t(0.975, 9) = 2.262 in every table."""
    low, high = mean_interval(10.0, 3.0, 10)
    assert high - 10.0 == pytest.approx(2.262 * 3.0 / 10**0.5, rel=1e-3)
    assert low == pytest.approx(20.0 - high)


@pytest.mark.parametrize(
    ("dimension", "runs", "low", "high"),
    [(1, 10, 3.247, 20.483), (9, 1, 2.700, 19.023), (2, 50, 74.222, 129.561)],
)
def test_chi_square_bounds_of_published_tables(dimension: int, runs: int, low: float, high: float) -> None:
    assert mean_square_bounds(dimension, runs) == pytest.approx((low / runs, high / runs), rel=1e-3)


def test_honest_filters_stay_within_the_bounds_19_times_in_20() -> None:
    draws = np.random.default_rng(1).standard_normal((4000, 30, 9))
    means = (draws**2).sum(axis=2).mean(axis=1)
    low, high = mean_square_bounds(9, 30)
    assert 0.94 < np.mean((means > low) & (means < high)) < 0.96


def test_spread_of_known_values() -> None:
    found = spread([1.0, 2.0, 3.0, 4.0, 100.0])
    assert (found.mean, found.median, found.minimum, found.maximum) == (22.0, 3.0, 1.0, 100.0)
    assert found.p95 == pytest.approx(80.8)
    assert found.deviation == pytest.approx(43.617, rel=1e-4)
    alone = spread([5.0])
    assert (alone.mean, alone.low, alone.high, alone.deviation) == (5.0, None, None, None)


def test_figures_leave_out_failed_runs_and_what_is_no_figure() -> None:
    done = {"status": "finished", "run": 0, "seed": 1, "met": True, "set.x": 3.0, "yaw_rms_deg": 2.0}
    failed = {"status": "failed", "run": 1, "seed": 2, "met": False, "set.x": 3.0}
    found = figures([done, failed, {**done, "yaw_rms_deg": None}])
    assert list(found) == ["yaw_rms_deg"]
    assert found["yaw_rms_deg"].count == 1


def test_mean_over_runs_leaves_out_what_is_missing() -> None:
    values = np.array([[1.0, np.nan, np.nan], [3.0, 4.0, np.nan]])
    assert nan_mean(values).tolist()[:2] == [2.0, 4.0]
    assert np.isnan(nan_mean(values)[2])


def test_swept_values_as_columns() -> None:
    assert swept_value("0.1") == 0.1
    assert swept_value("5_250_000") == 5.25e6
    assert swept_value("true") is True
    assert swept_value("perfect") == "perfect"
    assert swept_value("[1, 2]") == "[1, 2]"


def test_differences_are_paired_over_seeds() -> None:
    """Seeds spread by metres; the second set-up is 0.5 m worse in each of them."""
    setups = []
    for value, worse in (("0.1", 0.0), ("0.2", 0.5)):
        rows = tuple(
            {"status": "finished", "seed": seed, "met": True, "position_horizontal_rms_m": 4.0 * seed + worse}
            for seed in (1, 2, 3)
        )
        swept = (("gnss.latency_s", value),)
        setups.append(SetupSummary(Setup("full-rate", swept), 3, 0, 3, figures(rows), {}, rows))
    tables = {section.title: section for section in sections(Summary(tuple(setups), ()))}
    assert tables["Differences"].rows[0][:3] == ("full-rate", "0.2", "0.500 ± 0")
    assert tables["Set-ups side by side"].rows[1][:3] == ("full-rate", "0.2", "3")
