"""Pulled cables, disturbed lines, resets: each is told, bridged, and over again."""

from __future__ import annotations

import pytest
from board_run import Driven, fault
from dual_runs import RECEIVER, UNIT, drive


@pytest.fixture(scope="module")
def troubled() -> Driven:
    """A road drive with one trouble after the other."""
    faults = (
        fault("uart-cut", "imu", 100.0, 3.0),
        fault("uart-bit-errors", "imu", 115.0, 4.0, probability=1e-3),
        fault("uart-cut", "gnss", 130.0, 8.0),
        fault("pin-stuck", "GNSS_PPS", 150.0, 8.0),
        fault("chip-reset", UNIT, 170.0),
        fault("nav-nan", "dsp", 185.0),
        fault("nav-nan", "fpga", 186.0),
        fault("uart-garbage", "imu", 200.0),
        fault("chip-flags", UNIT, 215.0, 0.5, flags=1),
    )
    return drive("road", "duration_s=240", f"fault=[{', '.join(faults)}]")


def test_every_fault_struck(troubled: Driven) -> None:
    assert all(use.fired for use in troubled.result.faults), troubled.result.faults
    assert all(cpu.deadline_misses == 0 for cpu in troubled.result.cpu)


def test_a_pulled_imu_cable_is_told_and_bridged(troubled: Driven) -> None:
    assert 100.2 < troubled.said("IMU silent") < 101.0
    assert 103.0 < troubled.said("IMU answers again") < 104.0
    assert troubled.worst("error_north_m", 104.0, 130.0) < 12.0
    assert troubled.worst("error_yaw_deg", 125.0, 130.0) < 1.5


def test_bad_frames_are_refused_by_their_crc(troubled: Driven) -> None:
    assert 115.0 < troubled.said("IMU line disturbed", 114.0) < 117.0
    assert troubled.said("IMU line is good again", 119.0) < 125.0
    assert troubled.worst("error_roll_deg", 116.0, 130.0) < 1.0


def test_a_pulled_receiver_cable(troubled: Driven) -> None:
    assert 131.0 < troubled.said("GNSS lost") < 136.0
    assert 138.0 < troubled.said("GNSS is back") < 150.0


def test_what_comes_at_the_end_is_sound_again(troubled: Driven) -> None:
    assert troubled.said("state not a number", 184.0) < 187.0
    assert troubled.said("IMU: rate beyond its range", 214.0) < 216.0
    assert troubled.worst("error_yaw_deg", 230.0, 240.0) < 0.5
    assert troubled.worst("error_pitch_deg", 230.0, 240.0) < 0.2
    assert troubled.worst("error_north_m", 230.0, 240.0) < 8.0


@pytest.mark.parametrize("processor", ["dsp", "fpga"])
def test_a_reset_begins_anew(processor: str) -> None:
    driven = drive("static", "duration_s=70", f"fault=[{fault('cpu-reset', processor, 30.0)}]")
    resets = {cpu.name: cpu.resets for cpu in driven.result.cpu}
    assert resets == {"dsp": 0, "fpga": 0} | {processor: 1}
    navigating = [at_s for at_s, text in driven.words() if text == "mode: navigating"]
    assert len(navigating) == 2
    assert 30.0 < navigating[1] < 50.0
    if processor == "fpga":
        assert 30.0 < driven.said("front end restarted") < 31.0
    assert driven.worst("error_yaw_deg", navigating[1] + 2.0, 70.0) < 0.2
    assert driven.worst("error_north_m", navigating[1] + 2.0, 70.0) < 6.0


def test_a_missing_unit_is_told() -> None:
    driven = drive("static", "duration_s=20", f"fault=[{fault('chip-off', UNIT, 0.0)}]")
    assert driven.said("IMU silent") < 3.0
    assert driven.result.metrics["seconds_with_solution"] == 0.0


def test_a_missing_receiver_leaves_the_gyros_waiting() -> None:
    driven = drive("static", "duration_s=30", f"fault=[{fault('chip-off', RECEIVER, 0.0)}]")
    assert driven.said("mode: levelling") < 3.0
    assert not [text for _, text in driven.words() if text == "mode: navigating"]
