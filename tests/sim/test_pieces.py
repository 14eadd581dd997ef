"""What a piece of motion is sure not to exceed, against a look at every thousandth of it."""

import numpy as np
import pytest

from host.sim.trajectory.piece import Piece, constant, fall_window, ramp, smooth_step, wave

PIECES = (
    constant(4.0, -2.5),
    ramp(3.0, 7.0, -9.0),
    smooth_step(5.0, -1.0, 30.0).derivative(),
    wave(10.0, 4.0, 0.7, 1.2),
    wave(2.0, 4.0, 0.7, 1.2).times(fall_window(2.0)).plus((-3.0, 0.5)).integral(1.0).derivative(),
)


@pytest.mark.parametrize("piece", PIECES)
def test_a_bound_is_not_exceeded(piece: Piece) -> None:
    largest = max(abs(piece.value(tau)) for tau in np.linspace(0.0, piece.duration_s, 1001).tolist())
    assert largest <= piece.bound() * (1.0 + 1e-12)


def test_the_bound_of_what_stays_and_of_a_ramp_from_zero_is_reached() -> None:
    assert constant(4.0, -2.5).bound() == 2.5
    assert ramp(2.0, 0.0, -8.0).bound() == pytest.approx(8.0)
