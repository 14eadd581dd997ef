"""What float32 costs navigation, and that a run can be repeated."""

import numpy as np
import pytest
from float64_doors import float64_doors
from nav_drive import Drive, part, within_pi
from nav_run import run

from firmware.nav.config import NavConfig

CONFIG = NavConfig(latency_sigma=0.0)


@pytest.mark.soak
def test_float32_stays_within_five_centimetres_of_float64(town: Drive) -> None:
    """The same drive, the same filter, twice the digits."""
    drive = part(town, 0.0, 200.0)
    narrow, wide = run(drive, CONFIG), run(drive, CONFIG, float64_doors())
    both = (narrow.mode >= 3) & (wide.mode >= 3)
    assert np.array_equal(narrow.mode, wide.mode)
    assert np.max(np.linalg.norm((narrow.position - wide.position)[both], axis=1)) < 0.05
    assert np.max(np.linalg.norm((narrow.velocity - wide.velocity)[both], axis=1)) < 0.005
    attitude = within_pi(narrow.attitude - wide.attitude)[both]
    assert np.max(np.abs(np.degrees(attitude))) < 0.02


def test_two_runs_are_equal_bit_by_bit(town: Drive) -> None:
    """No hidden state, no clock."""
    first, second = (run(part(town, 0.0, 120.0), CONFIG) for _ in range(2))
    assert first.f.tobytes() == second.f.tobytes()
    assert first.i.tobytes() == second.i.tobytes()
