"""Headings that are wrong, late or missing: refused, counted, told, and never followed."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from tactical_drive import ANTENNA, BASELINE, NS, Drive, changed, make_drive
from tactical_run import Result, doors, run

from firmware.drivers import gnss_epoch as gnss
from firmware.nav import layout as at
from firmware.nav import reference_report as told
from firmware.nav.config import configure
from firmware.nav.flags import GNSS_REJECTED, NAVIGATING
from firmware.nav.full_combination import full_combination
from firmware.nav.reference_config import AttitudeReference

CONFIG = full_combination(BASELINE, antenna_lever_arm=ANTENNA)
Change = Callable[[NDArray[np.int64]], None]


def turned(degrees: float) -> Change:
    def change(e: NDArray[np.int64]) -> None:
        e[gnss.HEADING_E5DEG] = (e[gnss.HEADING_E5DEG] + round(degrees * 1e5)) % 36_000_000

    return change


def of_length(metres: float) -> Change:
    def change(e: NDArray[np.int64]) -> None:
        e[gnss.BASELINE_MM] = round(metres * 1e3)

    return change


def without_heading(e: NDArray[np.int64]) -> None:
    e[gnss.FLAGS] &= ~(gnss.HAS_HEADING | gnss.HAS_BASELINE)


def without_fix(e: NDArray[np.int64]) -> None:
    e[gnss.FLAGS] &= gnss.HAS_TIME


FAULTS = (
    (90.0, 119.0, turned(180.0)),
    (130.0, 134.0, turned(5.0)),
    (140.0, 149.0, turned(-5.0)),
    (155.0, 164.0, of_length(2.2)),
    (170.0, 199.0, without_heading),
    (210.0, 269.0, without_fix),
)


@pytest.fixture(scope="module")
def drive() -> Drive:
    return make_drive(2, duration_s=300.0)


@pytest.fixture(scope="module")
def faulty(drive: Drive) -> Result:
    for first, last, change in FAULTS:
        drive = changed(drive, first, last, change)
    return run(drive, CONFIG, "float32")


def test_wrong_headings_are_refused_and_counted(faulty: Result) -> None:
    counts = faulty.counts[-1]
    assert counts[told.FLIPPED] == 30
    assert counts[told.WRONG_LENGTH] == 10
    assert counts[told.MISSING] == 90
    assert 15 <= counts[told.REFUSED] <= 16  # a gate of 99.9 % may refuse one that is well
    ok = faulty.scored(30.0)
    assert np.degrees(np.max(np.abs(faulty.attitude[ok, 2]))) < 0.15


def test_flags_tell_while_it_lasts(faulty: Result) -> None:
    rejected, lost = faulty.seen("attitude_rejected"), faulty.seen("attitude_lost")
    assert rejected[(faulty.t > 92) & (faulty.t < 119)].all()
    assert rejected[(faulty.t > 156) & (faulty.t < 164)].all()
    assert not rejected[(faulty.t > 172) & (faulty.t < 300)].any()
    assert lost[(faulty.t > 97) & (faulty.t < 119)].all()
    assert lost[(faulty.t > 206) & (faulty.t < 209)].sum() == 0
    assert lost[(faulty.t > 176) & (faulty.t < 199)].all()


def test_position_returns_after_a_minute_without_jump(faulty: Result) -> None:
    """The epochs after the outage pass the gate at once; what had drifted is within what was claimed."""
    end = np.flatnonzero(faulty.t == 269.0)[0]
    error, sigma = np.abs(faulty.position[end]), faulty.sigma[end, :3]
    assert np.all(error < 4.0 * sigma)
    assert np.all(error < 20.0)
    assert faulty.seen("gnss_lost")[end]
    assert faulty.i[at.EVENT_COUNT + GNSS_REJECTED] == 0
    assert not faulty.seen("rejoined").any()


def test_a_flipped_baseline_that_lasts_never_wins(drive: Drive) -> None:
    one = run(changed(drive, 90.0, 1e9, turned(180.0)), CONFIG, "float32")
    assert np.all(one.mode[one.t > 20.0] == NAVIGATING)
    assert not one.seen("realigned").any()
    ok = one.scored(30.0)
    assert np.degrees(np.max(np.abs(one.attitude[ok, 2]))) < 0.15


def test_a_wrong_start_is_healed_when_the_course_is_a_witness(drive: Drive) -> None:
    """Five degrees off for as long as the vehicle rests: nothing can tell, until it drives."""
    one = run(changed(drive, 0.0, 60.0, turned(5.0)), CONFIG, "float32")
    assert abs(np.degrees(one.attitude[one.t == 60.0, 2][0]) - 5.0) < 0.3
    assert np.degrees(np.max(np.abs(one.attitude[one.t > 200.0, 2]))) < 0.15
    assert one.seen("rejoined").any()


@pytest.mark.parametrize("offset", [180.0, 40.0])
def test_a_wrong_baseline_does_not_begin_navigation(offset: float) -> None:
    """The gyros feel the Earth turn: after ten seconds of rest well enough to tell 40 degrees."""
    one = run(changed(make_drive(3, "static", 45.0), 0.0, 30.0, turned(offset)), CONFIG, "float32")
    assert np.all(one.mode[one.t <= 30.0] < NAVIGATING)
    assert one.seen("attitude_rejected")[(one.t > 16.0) & (one.t < 30.0)].all()
    assert one.mode[-1] == NAVIGATING
    assert abs(np.degrees(one.attitude[-1, 2])) < 0.4
    assert one.counts[-1, told.YAW_SOURCE] == 3


def test_records_in_strange_order_do_no_harm(drive: Drive) -> None:
    """Old ones, future ones, none that begins: nothing moves, nothing raises."""
    one = run(drive, CONFIG, "float32")
    door = doors("float32")[2]
    before = one.f[: at.CONFIG].copy()
    for offset in (-5 * NS, 5 * NS):
        e = drive.epochs[-1].copy()
        e[gnss.VALID_NS] = one.i[at.TIME] + offset
        door.attitude_step(one.f, one.i, e)
    moved = one.f[: at.CONFIG] != before
    assert not moved[at.QUATERNION : at.QUATERNION + 4].any()
    assert np.isfinite(one.f).all()


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"baseline": (0.0, 0.0, 2.0)}, r"AttitudeReference.baseline = \(0.0, 0.0, 2.0\) must be three"),
        ({"heading_noise": 0.0}, "AttitudeReference.heading_noise = 0.0 must be finite and positive"),
        ({"rejoin_after": float("nan")}, "AttitudeReference.rejoin_after = nan"),
    ],
)
def test_wrong_configuration_is_told(wrong: dict[str, object], message: str) -> None:
    config = full_combination(BASELINE, attitude=AttitudeReference(**wrong))  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=message):
        configure(np.zeros(10_000, np.float32), np.zeros(2_000, np.int64), config)


def test_arrays_without_room_for_the_reference_are_refused() -> None:
    with pytest.raises(ValueError, match="too short for an attitude reference"):
        configure(np.zeros(at.F_SIZE, np.float32), np.zeros(at.I_SIZE, np.int64), CONFIG)
