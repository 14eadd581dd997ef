"""What the FPGA collects: means at rest, what was gained in turning, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from firmware.apps.gfsins.collecting import AtRest, Readings, Turn, counts

FRACTION = 65536.0


def gathered(part: AtRest | Turn, rows: NDArray[np.int64]) -> NDArray[np.float64]:
    for row in rows:
        assert not part.is_done
        part.take(row)
    assert part.is_done
    return np.asarray(part.means / FRACTION)


def noise(seed: int, ticks: int, sigma: float = 1.1) -> NDArray[np.float64]:
    return np.random.default_rng(seed).normal(0.0, sigma, (ticks, 9))


def test_counts_are_taken_out_of_the_samples_of_seven_chips() -> None:
    values = np.array([[100 * chip + axis - 350 for axis in range(3)] for chip in range(7)])
    raw = b"".join(b"\x99" + row.astype("<i2").tobytes() for row in values)
    wanted = [*(values[k, k % 3] for k in range(6)), *values[6]]
    assert counts(np.frombuffer(raw, np.uint8)).tolist() == wanted


def test_means_are_those_of_the_counts() -> None:
    rows = np.rint(noise(1, 400) + np.linspace(-256.0, 256.0, 9)).astype(np.int64)
    rest = AtRest(400)
    assert gathered(rest, rows) == pytest.approx(rows.mean(axis=0), abs=2e-5)
    assert not rest.has_moved


@pytest.mark.parametrize("axis", [0, 4, 8])
def test_motion_is_no_rest(axis: int) -> None:
    for course in (
        np.linspace(0.0, 2.5, 400),  # it leans by half a degree
        6.0 * np.sin(np.arange(400) * 0.3),  # it shakes
        np.where(np.arange(400) == 200, 80.0, 0.0),  # somebody bumps into it
    ):
        rows = noise(2, 400)
        rows[:, axis] += course
        rest = AtRest(400)
        gathered(rest, np.rint(rows).astype(np.int64))
        assert rest.has_moved


def test_sensors_of_the_data_sheet_are_not_taken_for_motion() -> None:
    for seed in range(200):
        rest = AtRest(400)
        gathered(rest, np.rint(noise(seed, 400) + 251.3).astype(np.int64))
        assert not rest.has_moved, seed


def test_a_turn_gives_what_was_gained() -> None:
    """A speed that rises to 20 counts · s within two seconds, held for a third one."""
    rest = np.full(9, 250 << 16)
    speed = 20.0 * np.minimum(np.arange(601) / 300.0, 1.0)
    rows = 250.0 + np.diff(speed)[:, None] * 200.0 * np.linspace(-1.0, 1.0, 9)
    turn = Turn(rest, 400, 200)
    found = gathered(turn, np.rint(rows * 1.0).astype(np.int64))
    exact = (np.cumsum(np.rint(rows) - 250.0, axis=0) / 200.0)[400:].mean(axis=0)
    assert found == pytest.approx(exact, abs=1e-4)
    assert found == pytest.approx(20.0 * np.linspace(-1.0, 1.0, 9), abs=1.6)


def test_headings_are_averaged_across_north() -> None:
    readings = Readings(4)
    for heading in (3598, 2, 3594, 6):
        readings.take((heading, 1, -3, 0, 0))
    assert readings.is_done
    assert readings.means[0] / FRACTION % 3600 == pytest.approx(0.0, abs=1e-9)
    assert readings.means[1:3] == [65536, -3 * 65536]
    assert readings.spread(0) == 12
