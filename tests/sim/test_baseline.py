"""A receiver with two antennas: the vector between them, its errors, and what becomes of it in trouble."""

from __future__ import annotations

import math

import numpy as np
import pytest

from host.sim.scenario.errors import ScenarioError
from host.sim.scenario.schema import Scenario
from host.sim.world import World

SECOND = 1_000_000_000
ARM = np.array([2.0, 0.0, 0.0])


def standing(**more):
    return Scenario.model_validate(
        {
            "name": "standing",
            "place": {"latitude_deg": 30.5, "longitude_deg": 114.3},
            "initial": {"yaw_deg": 350.0, "pitch_deg": 5.0},
            "duration_s": 20_000.0,
            **more,
        }
    )


def solutions(scenario, seconds, arm=ARM):
    receiver = World(scenario).gnss("U3", None, arm)
    return [receiver.epoch(int(t * SECOND)).baseline for t in seconds]


def degrees_off(found, heading_deg):
    off = np.degrees([one.heading for one in found]) - heading_deg
    return (off + 180.0) % 360.0 - 180.0


QUIET = {"baseline": {"heading_white_deg": 0.0, "heading_markov_deg": 0.0, "length_white_m": 0.0}}


@pytest.mark.parametrize(
    ("arm", "heading_deg", "pitch_deg"),
    [
        ((2.0, 0.0, 0.0), 350.0, 5.0),
        ((0.0, 1.5, 0.0), 80.0, 0.0),
        ((-1.0, 0.0, 0.0), 170.0, -5.0),
        ((0.0, 0.0, 2.0), 350.0, -85.0),
    ],
)
def test_without_errors_it_is_the_direction_of_the_arm(arm, heading_deg, pitch_deg):
    (found,) = solutions(standing(gnss=QUIET), [3], np.array(arm))
    assert found.fix == "FIXED"
    assert math.degrees(found.heading) == pytest.approx(heading_deg, abs=1e-9)
    assert math.degrees(found.pitch) == pytest.approx(pitch_deg, abs=1e-9)
    assert found.length == pytest.approx(np.linalg.norm(arm))


@pytest.mark.parametrize("length", [1.0, 2.0, 5.0])
def test_errors_have_the_claimed_size_and_go_with_the_inverse_of_the_length(length):
    seconds = np.arange(0, 12_000, 4)
    found = solutions(standing(), seconds, np.array([length, 0.0, 0.0]))
    heading = degrees_off(found, 350.0)
    pitch = np.degrees([one.pitch for one in found]) - 5.0
    sigma = math.hypot(0.08, 0.06) * 2.0 / length
    assert np.degrees(found[0].heading_acc) == pytest.approx(sigma / math.cos(math.radians(5.0)))
    assert heading.std() == pytest.approx(sigma, rel=0.07)
    assert pitch.std() == pytest.approx(1.7 * sigma, rel=0.07)
    assert np.degrees(found[0].pitch_acc) == pytest.approx(1.7 * sigma)
    # white and slow parts: the Allan variance at 4 s holds the white one almost alone
    white = math.sqrt(0.5 * np.mean(np.diff(heading) ** 2))
    slow = 0.06 * 2.0 / length * math.sqrt(1.0 - math.exp(-4.0 / 60.0))
    assert white == pytest.approx(math.hypot(0.08 * 2.0 / length, slow), rel=0.05)


def test_after_an_outage_ambiguities_float_before_they_are_fixed():
    scenario = standing(
        outage=[{"start_s": 100.0, "duration_s": 20.0}],
        gnss={"reacquisition_s": 2.0, "baseline": {"fixing_s": 15.0, "float_factor": 8.0}},
    )
    found = solutions(scenario, range(95, 145))
    told = {second: one.fix for second, one in enumerate(found, start=95)}
    assert {told[t] for t in range(100, 122)} == {"NONE"}
    assert {told[t] for t in range(122, 137)} == {"FLOAT"}
    assert {told[t] for t in (99, *range(137, 145))} == {"FIXED"}
    assert found[30].heading_acc == pytest.approx(8.0 * found[0].heading_acc)


def test_faults_of_the_second_antenna_strike_it_alone():
    faults = [
        {"kind": "gnss-baseline-lost", "target": "U3", "at_s": 10.0, "duration_s": 5.0},
        {
            "kind": "gnss-baseline-jump",
            "target": "U3",
            "at_s": 20.0,
            "duration_s": 5.0,
            "parameters": {"heading_deg": 15.0, "pitch_deg": -1.0},
        },
    ]
    seconds = range(30)
    clean, struck = solutions(standing(), seconds), solutions(standing(fault=faults), seconds)
    assert [one.fix for one in struck[10:15]] == ["NONE"] * 5
    for second in set(seconds) - set(range(10, 15)) - set(range(20, 25)):
        assert struck[second] == clean[second]
    for second in range(20, 25):
        turn = (struck[second].heading - clean[second].heading) % (2.0 * math.pi)
        assert math.degrees(turn) == pytest.approx(15.0)
        assert math.degrees(struck[second].pitch - clean[second].pitch) == pytest.approx(-1.0)
        assert struck[second].heading_acc == clean[second].heading_acc


def test_jamming_weakens_the_baseline_and_takes_it_in_the_end():
    def jammed(loss_db):
        fault = {"kind": "gnss-jamming", "target": "U3", "at_s": 0.0, "parameters": {"loss_db": loss_db}}
        return solutions(standing(fault=[fault]), range(0, 2000, 4))

    clean, mild = solutions(standing(), range(0, 2000, 4)), jammed(6.0)
    assert degrees_off(mild, 350.0).std() > 1.7 * degrees_off(clean, 350.0).std()
    assert {one.fix for one in jammed(40.0)} == {"NONE"}


def test_the_second_antenna_changes_nothing_else():
    one, two = World(standing(), 3).gnss("U3"), World(standing(), 3).gnss("U3", None, ARM)
    for second in range(50):
        first, with_both = one.epoch(second * SECOND), two.epoch(second * SECOND)
        assert first.baseline is None
        assert first.latitude == with_both.latitude
        assert first.velocity_ned == with_both.velocity_ned


def test_what_cannot_be_is_refused():
    with pytest.raises(ScenarioError, match=r"U3: its antennas are 0\.02 m apart; at least 0\.1 m"):
        World(standing()).gnss("U3", np.zeros(3), np.array([0.02, 0.0, 0.0]))
    lost = {"kind": "gnss-baseline-lost", "target": "U3", "at_s": 1.0}
    with pytest.raises(ScenarioError, match="target U3 has one antenna"):
        World(standing(fault=[lost])).gnss("U3")
    with pytest.raises(ScenarioError, match="it takes none"):
        World(standing(fault=[lost | {"parameters": {"heading_deg": 1.0}}])).gnss("U3", None, ARM)


def test_a_fault_that_finds_no_baseline_has_not_struck():
    faults = [
        {"kind": "gnss-baseline-lost", "target": "U3", "at_s": 10.0, "duration_s": 10.0},
    ]
    scenario = standing(
        fault=faults, outage=[{"start_s": 5.0, "duration_s": 10.0}], gnss={"reacquisition_s": 0.0}
    )
    receiver = World(scenario).gnss("U3", None, ARM)
    for second in range(30):
        receiver.epoch(second * SECOND)
    assert [glitch.fired for glitch in receiver.glitches] == [5]
