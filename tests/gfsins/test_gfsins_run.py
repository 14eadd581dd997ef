"""gfsins from end to end: both feeds, its faults, its time."""

from __future__ import annotations

import pytest
from board_run import Driven, fault
from gfsins_runs import drive

FAULTS = (
    fault("spi-missing", "accelerometer3", 20.0, 2.0),
    fault("packet-loss", "packets", 24.0, 1.0, probability=0.1),
    fault("packet-bit-errors", "packets", 25.5, 1.0, probability=5e-5),
    fault("packet-word-slip", "packets", 27.0, 1.0, probability=0.02),
    fault("i2c-nack", "compass", 29.0, 5.0),
    fault("uart-cut", "gnss", 40.0, 10.0),
    fault("nav-nan", "dsp", 54.2),
    fault("cpu-reset", "fpga", 56.0),
    fault("cpu-reset", "dsp", 62.0),
)


def clean() -> Driven:
    return drive("chapter5", "equivalent", "duration_s=50")


def disturbed() -> Driven:
    return drive("chapter5", "equivalent", "duration_s=80", f"fault=[{', '.join(FAULTS)}]")


def test_chapter_5_is_held() -> None:
    driven = clean()
    assert driven.said("aligned: heading, pitch, roll 30.3, 0.2, 0.2") == pytest.approx(3.4, abs=0.5)
    assert driven.worst("error_yaw_deg", 30.0, 50.0) < 0.5
    assert driven.worst("error_roll_deg", 30.0, 50.0) < 0.3
    assert driven.worst("error_v_north_mps", 30.0, 50.0) < 0.3
    assert driven.worst("error_north_m", 30.0, 50.0) < 10.0


def test_both_filters_tell_what_they_take_for_the_state() -> None:
    data = clean().result.data
    assert data is not None
    for which, series in enumerate(data.filters):
        times = series.column("t_s")
        assert set(series.column("filter")) == {which}
        assert 45 <= len(times) <= 48
        assert times[1:] - times[:-1] == pytest.approx(1.0, abs=0.02)
        late = times > 30.0
        assert abs(series.column("error_yaw_deg")[late]).max() < 0.6
        assert abs(series.column("error_north_m")[late]).max() < 15.0
        assert (series.column("sigma_north_m")[late] < 10.0).all()
        assert not series.column("status").any()
    assert len(data.filters) == 2


def test_every_tick_is_a_packet_and_every_deadline_is_met() -> None:
    result = clean().result
    by_name = {cpu.name: cpu for cpu in result.cpu}
    tasks = {task.name: task for cpu in result.cpu for task in cpu.tasks}
    assert tasks["acquisition"].activations == tasks["packet"].activations == tasks["navigation"].activations
    assert 49.8 * 200 < tasks["navigation"].activations <= 50 * 200
    assert all(cpu.deadline_misses == cpu.overruns == 0 for cpu in result.cpu)
    assert by_name["dsp"].load < by_name["fpga"].load < 0.1


def test_buses_are_as_busy_as_their_clocks_say() -> None:
    buses = {bus.name: bus for bus in clean().result.buses}
    packet_s = 96 * 8 / 8.75e6 + 47 * 100e-9
    assert buses["packets.fpga"].load == pytest.approx(200 * packet_s, rel=0.01)
    assert buses["packets.dsp"].transactions == buses["packets.fpga"].transactions
    for k in range(7):  # FIFO_STATUS each tick, and six data bytes for each of some 200 samples
        sample_s, status_s = 56 / 1.4e6, 16 / 1.4e6
        assert buses[f"spi{k + 1}"].load == pytest.approx(200 * (sample_s + status_s), rel=0.02)


def test_registers_alone_hold_attitude_by_the_compass() -> None:
    driven = drive("static", "adxl345", "duration_s=60", f"fault=[{fault('chip-off', 'U2', 45.0, 2.0)}]")
    assert driven.worst("error_roll_deg", 20.0, 45.0) < 3.0
    assert driven.worst("error_yaw_deg", 20.0, 45.0) < 4.0
    assert driven.worst("error_north_m", 20.0, 45.0) < 15.0
    assert driven.said("accelerometer 2 missing") < 47.5
    assert driven.said("accelerometer 2 no longer missing") < 50.0
    assert driven.worst("error_north_m", 50.0, 60.0) < 20.0


def test_a_chip_that_is_missing_is_told_and_comes_back() -> None:
    driven = disturbed()
    assert 20.0 < driven.said("accelerometer 3 missing", 20.0) < 22.5
    assert driven.said("accelerometer 3 no longer missing", 22.0) < 25.0


def test_packets_lost_and_spoilt_do_no_harm() -> None:
    driven = disturbed()
    driven.said("packets:", 24.0)
    assert driven.worst("error_north_m", 24.0, 29.0) < 10.0
    assert driven.worst("error_yaw_deg", 24.0, 29.0) < 0.7


def test_a_compass_that_does_not_answer_is_cut_off_and_comes_back() -> None:
    driven = disturbed()
    assert 31.0 < driven.said("compass filter isolated: silent", 29.0) < 34.0
    again_s = 2.0 + 1.2 + 3.0 + 1.0  # next attempt, bringing it up, 30 readings believed, next fusion
    assert driven.said("compass filter trusted again", 34.0) < 34.0 + again_s + 0.3
    assert driven.worst("error_yaw_deg", 29.0, 40.0) < 1.5


def test_silence_of_gps_is_cut_off_and_comes_back() -> None:
    driven = disturbed()
    assert 44.0 < driven.said("GPS filter isolated: silent", 40.0) < 46.0  # 5 s after the last epoch, at 39
    assert driven.said("GPS filter trusted again", 50.0) < 57.0
    assert driven.worst("error_north_m", 40.0, 56.0) < 15.0


def test_a_state_that_is_no_number_is_begun_again_from_a_sound_filter() -> None:
    driven = disturbed()
    assert driven.said("state not a number", 54.0) < 54.5
    assert driven.worst("error_north_m", 54.2, 56.0) < 15.0
    assert driven.worst("error_yaw_deg", 54.2, 56.0) < 1.5


def test_a_reset_of_the_fpga_is_told_and_navigation_goes_on() -> None:
    driven = disturbed()
    assert driven.said("acquisition restarted", 56.0) < 58.0
    assert driven.worst("error_north_m", 56.5, 62.0) < 15.0
    assert driven.worst("error_yaw_deg", 56.5, 62.0) < 1.5


def test_a_reset_of_the_dsp_begins_anew_while_the_fpga_runs() -> None:
    driven = disturbed()
    assert 64.0 < driven.said("aligned: heading", 62.0) < 70.0
    assert driven.said("what was entered is not of here", 62.0) < 70.0
    assert driven.worst("error_north_m", 77.0, 80.0) < 25.0
    resets = {cpu.name: cpu.resets for cpu in driven.result.cpu}
    assert resets == {"fpga": 1, "dsp": 1}


def test_an_accelerometer_that_is_turned_is_told_and_nothing_is_navigated() -> None:
    turned = "board.chips.U3.mounting=[[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]"
    driven = drive("static", "adxl345", "duration_s=14", turned)
    assert driven.said("accelerometer 3 at odds with the others") < 4.0
    assert not (driven.column("mode") >= 3).any()
