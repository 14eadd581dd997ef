"""Gauss–Markov processes and random walks have the statistics that define them."""

import math

import numpy as np
import pytest

from host.sim.errors.processes import Process, ProcessBank
from host.sim.trajectory.motion import CHUNK_SHIFT

COUNT = 200


def run(correlation_s, chunks, sigma=2.0, seed=1):
    bank = ProcessBank([Process(f"p{i}", sigma, correlation_s) for i in range(COUNT)], seed)
    parts = [bank.nodes(k)[:-1] for k in range(chunks)]
    return np.vstack(parts), (1 << bank.node_shift) * 1e-9


@pytest.mark.parametrize("correlation_s", [3.0, 60.0, 300.0])
def test_gauss_markov_is_stationary_and_forgets_at_its_rate(correlation_s):
    x, step = run(correlation_s, 6)
    for row in (0, len(x) // 2, len(x) - 1):
        assert x[row].std() == pytest.approx(2.0, rel=4 / math.sqrt(2 * COUNT))
    lag = round(correlation_s / step)
    if lag < len(x):
        pairs = x[:-lag] * x[lag:]
        correlation = pairs.mean() / (x * x).mean()
        independent = COUNT * len(pairs) / max(lag, 1)
        assert correlation == pytest.approx(
            math.exp(-lag * step / correlation_s), abs=4 / math.sqrt(independent)
        )


def test_linear_interpolation_between_nodes_lacks_little_variance():
    x, _ = run(3.0, 6)
    middle = 0.5 * (x[1:] + x[:-1])
    assert (middle**2).mean() / (x**2).mean() > 0.98


def test_random_walk_grows_with_the_root_of_time():
    x, step = run(None, 4, sigma=0.1)
    assert (x[0] == 0.0).all()
    for row in (len(x) // 4, len(x) - 1):
        assert x[row].std() == pytest.approx(0.1 * math.sqrt(row * step), rel=4 / math.sqrt(2 * COUNT))


def test_an_instant_far_back_comes_out_the_same():
    bank = ProcessBank([Process("p", 1.0, 10.0)], 7)
    first = bank.nodes(2).copy()
    bank.nodes(200)
    np.testing.assert_array_equal(bank.nodes(2), first)


def test_chunks_join():
    bank = ProcessBank([Process("p", 1.0, 10.0), Process("q", 1.0, None)], 7)
    np.testing.assert_array_equal(bank.nodes(0)[-1], bank.nodes(1)[0])
    assert (len(bank.nodes(0)) - 1) << bank.node_shift == 1 << CHUNK_SHIFT
