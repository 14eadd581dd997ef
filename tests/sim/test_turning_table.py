"""The turning table against finite differences of its own attitude, and against gravity and Earth rate."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from host.sim.trajectory.kinematics import C_NB, FORCE, OMEGA_DOT, OMEGA_IB
from host.sim.turning_table import TurningTable

LATITUDE = math.radians(28.2)
EARTH = 7.292115e-5 * np.array((math.cos(LATITUDE), 0.0, -math.sin(LATITUDE)))
S = 1_000_000_000
UP = np.array(((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0)))
"""Some attitude, C_n_b: x up."""


def table() -> TurningTable:
    return TurningTable(LATITUDE, 1.97, 5.0, np.eye(3))


def attitudes(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    return rows[:, C_NB : C_NB + 9].reshape(-1, 3, 3)


def test_it_turns_by_the_rate_that_it_tells() -> None:
    turning = table()
    turning.turn_to(UP, 0)
    turning.spin(np.array((1.0, 0.0, 0.0)), math.radians(-180.0), 4.0, turning.rests_from_ns)
    times = np.arange(0, turning.rests_from_ns + S // 2, 1_000_000)
    rows = turning.rows(times)
    c = attitudes(rows)
    assert c @ c.transpose(0, 2, 1) == pytest.approx(np.broadcast_to(np.eye(3), c.shape), abs=1e-12)
    # ω_nb from two neighbours, by the skew part of C(t)' C(t + dt)
    step = c[:-2].transpose(0, 2, 1) @ c[2:]
    skew = 0.5 * (step - step.transpose(0, 2, 1))
    found = np.stack((skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]), axis=1) / 2e-3
    told = rows[1:-1, OMEGA_IB : OMEGA_IB + 3] - np.einsum("kij,i->kj", c[1:-1], EARTH)
    assert found == pytest.approx(told, abs=5e-5)
    assert np.abs(told).max() == pytest.approx(math.pi, rel=1e-9)
    change = (rows[2:, OMEGA_IB : OMEGA_IB + 3] - rows[:-2, OMEGA_IB : OMEGA_IB + 3]) / 2e-3
    assert change == pytest.approx(rows[1:-1, OMEGA_DOT : OMEGA_DOT + 3], abs=0.03)


def test_at_rest_it_feels_gravity_and_the_earth() -> None:
    turning = table()
    turning.turn_to(UP, 0)
    row = turning.rows(np.array([turning.rests_from_ns + S]))[0]
    assert row[C_NB : C_NB + 9].reshape(3, 3) == pytest.approx(UP, abs=1e-12)
    gravity = 9.780327 * (1.0 + 0.0053024 * math.sin(LATITUDE) ** 2 - 0.0000058 * math.sin(2 * LATITUDE) ** 2)
    assert row[FORCE : FORCE + 3] == pytest.approx((gravity, 0.0, 0.0), abs=5e-5)
    assert row[OMEGA_IB : OMEGA_IB + 3] == pytest.approx(UP.T @ EARTH, abs=1e-15)


def test_what_was_told_already_stays_so() -> None:
    turning = table()
    before = turning.rows(np.arange(0, S, S // 10))
    turning.turn_to(UP, S // 2)
    assert np.array_equal(turning.rows(np.arange(0, S, S // 10)), before)
    assert turning.rests_from_ns > S


@pytest.mark.parametrize("half_turn", [np.diag((-1.0, -1.0, 1.0)), np.diag((1.0, -1.0, -1.0))])
def test_half_a_turn_ends_where_it_should(half_turn: NDArray[np.float64]) -> None:
    turning = table()
    turning.turn_to(half_turn, 0)
    assert turning.attitude == pytest.approx(half_turn, abs=1e-9)
