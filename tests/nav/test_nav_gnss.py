"""GNSS epochs: when they are compared, how they are weighed, refused, and believed again."""

import dataclasses
import math

import numpy as np
import pytest
from nav_drive import NS, Drive, make_drive, part
from nav_run import dcm, run

from firmware.drivers import gnss_epoch as gnss
from firmware.nav import layout as at
from firmware.nav.config import NavConfig
from firmware.nav.flags import GNSS_STALE, GNSS_TIME_JUMP

CONFIG = NavConfig(latency_sigma=0.0)
METRE_NANODEG = 9000


def shifted(drive: Drive, start_s: float, end_s: float, metres: float) -> Drive:
    """A receiver whose position jumps north."""
    for _, record in drive.epochs:
        if start_s * NS <= record[gnss.VALID_NS] < end_s * NS:
            record[gnss.LAT_NANODEG] += round(metres * METRE_NANODEG)
    return drive


def test_age_of_an_epoch_does_not_matter(town: Drive) -> None:
    """Epochs that come 0.85 s late give the solution of those that come after 0.05 s.

    Looked at when both have arrived; compared where they are taken, they would be wrong by 10 m.
    """
    results = []
    for delay_s in (0.05, 0.85):
        drive = part(town, 0.0, 150.0)
        drive.epochs = [(int(e[gnss.VALID_NS]) + round(delay_s * NS), e) for _, e in drive.epochs]
        results.append(run(drive, CONFIG))
    prompt, late = results
    both = (prompt.t > 105.0) & (np.abs(prompt.t % 1.0 - 0.9) < 0.01)
    assert np.max(np.linalg.norm((late.position - prompt.position)[both], axis=1)) < 0.1
    assert np.max(np.linalg.norm((late.velocity - prompt.velocity)[both], axis=1)) < 0.05
    turned = both & (prompt.t > 120.0)  # before, yaw is that of the epoch which began navigation
    assert np.max(np.abs(np.degrees((late.attitude - prompt.attitude)[turned]))) < 0.1
    assert np.all(np.abs((late.attitude - prompt.attitude)[both]) < prompt.sigma[both, 6:9])


def test_lever_arm_of_the_antenna(town: Drive) -> None:
    """An antenna 2 m ahead, 1 m to the right and on the roof, told and not told."""
    truth = part(town, 0.0, 140.0)
    lever = np.array([2.0, 1.0, -1.5])
    drive = part(truth, 0.0, 140.0)
    columns = (truth.truth.yaw, truth.truth.pitch, truth.truth.roll)
    for _, record in drive.epochs:
        k = round(record[gnss.VALID_NS] / (NS // 10)) - 1
        if not 1 <= k < len(columns[0]) - 1:
            continue
        here, before, after = (dcm(*(c[n] for c in columns)) @ lever for n in (k, k - 1, k + 1))
        record[gnss.LAT_NANODEG] += round(here[0] / 6.37e6 * 57.29577951 * 1e9)
        record[gnss.LON_NANODEG] += round(here[1] / 6.37e6 / np.cos(truth.truth.latitude[k]) * 57.29577951e9)
        record[gnss.HEIGHT_MM] -= round(here[2] * 1e3)
        velocity = (after - before) / 0.2
        record[gnss.VEL_N_MMPS : gnss.VEL_D_MMPS + 1] += np.round(velocity * 1e3).astype(np.int64)
    told = run(drive, dataclasses.replace(CONFIG, antenna_lever_arm=tuple(lever.tolist())))
    plain = run(truth, CONFIG)
    late = plain.t > 100.0
    assert np.max(np.linalg.norm((told.position - plain.position)[late], axis=1)) < 0.3
    not_told = run(drive, CONFIG)
    assert np.max(np.linalg.norm((not_told.position - plain.position)[late], axis=1)) > 1.0


def test_short_jump_is_not_swallowed(town: Drive) -> None:
    """200 m for 6 s: refused, the solution stays, no mark is left."""
    result = run(shifted(part(town, 0.0, 150.0), 110.0, 116.0, 200.0), CONFIG)
    assert np.max(result.horizontal[result.t > 95.0]) < 4.0
    assert np.any(result.seen("gnss_rejected"))
    assert not np.any(result.seen("rejoined"))


def test_lasting_jump_is_believed_in_the_end(town: Drive) -> None:
    """Ten seconds refused, then the filter joins the receiver again, with its velocity unharmed."""
    result = run(shifted(part(town, 0.0, 150.0), 110.0, 999.0, 200.0), CONFIG)
    before, after = (result.t > 110.0) & (result.t < 119.0), result.t > 123.0
    assert np.max(result.horizontal[before]) < 4.0
    assert np.all(np.abs(result.position[after, 0] - 200.0) < 5.0)
    assert np.max(np.linalg.norm(result.velocity[after], axis=1)) < 0.3
    assert np.any(result.seen("rejoined"))


def test_small_error_is_averaged_by_its_weight(town: Drive) -> None:
    """One epoch off by 2 m (within the gate) moves the position by the gain of a walk seen in white noise."""
    plain = run(part(town, 0.0, 150.0), CONFIG)
    one = run(shifted(part(town, 0.0, 150.0), 120.0, 120.5, 2.0), CONFIG)
    moved = one.position[:, 0] - plain.position[:, 0]
    walk, white = CONFIG.position_walk**2, CONFIG.position_noise**2
    predicted = 0.5 * (walk + math.sqrt(walk * walk + 4.0 * walk * white))
    gain = predicted / (predicted + white)
    assert np.max(moved[one.t > 121.0]) == pytest.approx(2.0 * gain, rel=0.2)
    assert np.max(np.abs(moved[one.t > 135.0])) < 0.1


@pytest.mark.parametrize("jump_ms", [5000, -3000, 86_400_000 // 2])
def test_time_jump_is_ignored_then_accepted(town: Drive, jump_ms: int) -> None:
    """The epochs' time of day jumps: they are left out until three in a row agree."""
    drive = part(town, 0.0, 150.0)
    for _, record in drive.epochs:
        if record[gnss.VALID_NS] >= 120 * NS:
            record[gnss.TIME_OF_DAY_MS] = (record[gnss.TIME_OF_DAY_MS] + jump_ms) % 86_400_000
    result = run(drive, CONFIG)
    assert result.i[at.EVENT_COUNT + GNSS_TIME_JUMP] == 1
    assert np.max(result.horizontal[result.t > 95.0]) < 4.0
    taken = run(part(town, 0.0, 150.0), CONFIG).i[at.UPDATES] - result.i[at.UPDATES]
    assert taken == 4


def test_midnight_is_no_jump(town: Drive) -> None:
    """Time of day begins anew."""
    drive = part(town, 0.0, 130.0)
    for _, record in drive.epochs:
        record[gnss.TIME_OF_DAY_MS] = (record[gnss.VALID_NS] // 1_000_000 - 110_000) % 86_400_000
    assert run(drive, CONFIG).i[at.EVENT_COUNT + GNSS_TIME_JUMP] == 0


@pytest.mark.parametrize("shift_s", [-2.0, 1.0])
def test_epoch_outside_the_history_is_stale(town: Drive, shift_s: float) -> None:
    """Validity before the history, or in the future: refused and told, nothing spoilt."""
    drive = part(town, 0.0, 130.0)
    for _, record in drive.epochs:
        if 110 * NS < record[gnss.VALID_NS] < 112 * NS:
            record[gnss.VALID_NS] += round(shift_s * NS)
            record[gnss.TIME_OF_DAY_MS] += round(shift_s * 1000)
    result = run(drive, CONFIG)
    assert np.max(result.horizontal[result.t > 95.0]) < 6.0
    if shift_s < 0:
        assert result.i[at.EVENT_COUNT + GNSS_STALE] >= 1


def test_speed_and_course_alone_suffice() -> None:
    """RMC and VTG only: two-dimensional velocity, none below 1 m/s, latency estimated."""
    drive = make_drive("town-open", 1, duration_s=200.0, velocity="2d", time_pulse=False)
    result = run(drive, NavConfig())
    late = result.t > 140.0
    assert np.sqrt(np.mean(np.sum(result.velocity[late, :2] ** 2, axis=1))) < 0.1
    assert np.max(np.abs(np.degrees(result.attitude[late]))) < 1.5


def test_latency_is_estimated_without_a_time_pulse() -> None:
    """The tag assumes 80 ms; the receiver takes longer by 40 ms, two sigma of the prior."""
    drive = make_drive("town-open", 1, duration_s=500.0)
    for _, record in drive.epochs:
        record[gnss.VALID_NS] += 40_000_000
    result = run(drive, NavConfig())
    latency, sigma = result.biases[-1, 8], result.biases[-1, 17]
    assert abs(latency - 0.12) < 3.5 * sigma
    assert abs(latency - 0.12) < 0.015
    frozen = run(drive, CONFIG)
    assert frozen.biases[-1, 8] == pytest.approx(0.08)
    assert frozen.biases[-1, 17] == 0.0


def test_two_dimensional_fix_leaves_height_alone(town: Drive) -> None:
    """FIX_TYPE 2: the receiver holds its height, 60 m off; it must not pull the solution."""
    drive = part(town, 0.0, 150.0)
    for _, record in drive.epochs:
        if record[gnss.VALID_NS] > 110 * NS:
            record[gnss.FIX_TYPE] = 2
            record[gnss.HEIGHT_MM] += 60_000
    result = run(drive, CONFIG)
    assert np.max(np.abs(result.position[result.t > 110.0, 2])) < 8.0
    assert not np.any(result.seen("gnss_rejected")[result.t > 110.0])


def test_bad_accuracy_claim_is_believed(town: Drive) -> None:
    """Errors of 15 m that the receiver confesses to hardly move the solution."""
    drive = shifted(part(town, 0.0, 150.0), 120.0, 130.0, 15.0)
    for _, record in drive.epochs:
        if 120 * NS <= record[gnss.VALID_NS] < 130 * NS:
            record[gnss.H_ACC_MM] = 30_000
    result = run(drive, CONFIG)
    assert not np.any(result.seen("gnss_rejected")[result.t > 100.0])
    assert np.max(np.abs(result.position[result.t > 120.0, 0])) < 3.0


def test_lost_and_back(town: Drive) -> None:
    """The flag follows the fixes."""
    drive = part(town, 0.0, 150.0)
    drive.epochs = [(t, e) for t, e in drive.epochs if not 110 * NS < t < 130 * NS]
    result = run(drive, CONFIG)
    t, lost = result.t, result.seen("gnss_lost")
    assert np.all(lost[(t > 115.0) & (t < 129.0)])
    assert not np.any(lost[(t > 90.0) & (t < 110.0)])
    assert not np.any(lost[t > 132.0])
