"""Streamed figures against numpy over the whole data."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from host.record.series import DecimatedSeries
from host.score.statistic import Statistic


def filled(values, cuts=()):
    statistic = Statistic()
    for part in np.split(np.asarray(values, dtype=float), cuts):
        statistic.add(part)
    return statistic


def test_figures_of_a_normal_distribution():
    values = np.abs(np.random.default_rng(1).normal(0, 2.0, 20_000))
    statistic = filled(values, cuts=[1, 7, 5000])
    assert statistic.rms() == pytest.approx(np.sqrt(np.mean(values**2)), rel=1e-12)
    assert statistic.mean() == pytest.approx(values.mean(), rel=1e-12)
    assert statistic.max() == values.max()
    for share in (0.05, 0.5, 0.95, 0.999):
        assert statistic.quantile(share) == pytest.approx(
            np.quantile(values, share, method="inverted_cdf"), rel=0.0028
        )


@given(st.lists(st.floats(1e-5, 1e8), min_size=1, max_size=60), st.floats(0.01, 1.0))
def test_quantile_is_within_the_stated_bound(values, share):
    exact = np.quantile(values, share, method="inverted_cdf")
    assert filled(values).quantile(share) == pytest.approx(exact, rel=0.0028)


def test_a_constant_error_has_itself_as_every_figure():
    statistic = filled(np.full(100, 0.75))
    assert statistic.rms() == pytest.approx(0.75)
    assert statistic.quantile(0.95) == pytest.approx(0.75, rel=0.0028)
    assert statistic.max() == 0.75


def test_no_value_gives_no_figure_and_nan_is_counted_apart():
    statistic = filled([np.nan, np.inf])
    assert statistic.not_finite == 2
    assert [statistic.mean(), statistic.rms(), statistic.max(), statistic.quantile(0.5)] == [None] * 4


@given(st.integers(0, 300), st.lists(st.integers(0, 300), max_size=6))
def test_series_keeps_evenly_spaced_rows_however_they_come(count, cuts):
    series = DecimatedSeries(["t"], limit=16)
    rows = np.arange(count, dtype=float)[:, None]
    for part in np.split(rows, sorted(cut for cut in cuts if cut <= count)):
        series.add(part)
    stride = 1
    while -(-count // stride) > 16:
        stride *= 2
    np.testing.assert_array_equal(series.column("t"), np.arange(0, count, stride))


def test_series_needs_an_even_limit():
    with pytest.raises(ValueError, match="limit is 7; an even number"):
        DecimatedSeries(["t"], limit=7)
