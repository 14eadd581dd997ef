"""The verdict on calibrated rates: by the uncertainty of what was changed, not by what it was before."""

from __future__ import annotations

import numpy as np
import pytest

from firmware.apps.gfsins import calibration as cal
from firmware.apps.gfsins.calibration import Calibration
from firmware.apps.gfsins.corrections import Corrections
from hal.emulated.cpu import EmulatedCpu
from hal.emulated.flash import EmulatedFlash
from hal.emulated.virtual_time import VirtualTime
from host.calibrate.judging import Judged, judge_rates
from host.calibrate.operator import Account
from host.calibrate.true_errors import NineAxes

SIGMA = 0.003
SCALE = 1.04
"""Of A2 and A6, which make the rate about x with A8 and A9."""


def judged(found_xx: float) -> Judged:
    rows = np.zeros((9, 3))
    rows[np.arange(9), np.arange(9) % 3] = 1.0
    rows[1], rows[5] = SCALE * rows[1], SCALE * rows[5]
    flash = EmulatedFlash(EmulatedCpu(VirtualTime(), "fpga", 70_000_000), "calibration")
    held = Calibration(flash, Corrections())
    held.load()
    matrix = (found_xx, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    assert held.keep({cal.RATES: (*matrix, *[0.0] * 3, *[SIGMA] * 12)})
    return judge_rates(Account("rates", done=True), held, NineAxes(rows, np.zeros(9)))


@pytest.mark.parametrize(
    ("error_sigmas", "met"),
    [(0.0, True), (2.0, True), (-2.0, True), (6.5, False), (-6.5, False)],
)
def test_what_was_changed_must_be_right_to_its_uncertainty(error_sigmas: float, met: bool) -> None:
    found = judged(1.0 / SCALE + error_sigmas * SIGMA)
    rate = found.figures[1]
    assert rate.before == pytest.approx(100.0 * (SCALE - 1.0) / np.sqrt(3.0), rel=0.02)
    assert found.met == met


def test_what_is_not_significant_stays_as_it_was() -> None:
    rate = judged(1.0 - 2.0 * SIGMA).figures[1]
    assert rate.value == rate.before
