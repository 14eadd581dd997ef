"""Bad input of gfsins with its real accelerometers: told in words and flags, and over when it is over."""

from __future__ import annotations

import numpy as np
import pytest
from board_run import Driven, fault
from gfsins_runs import drive

from firmware.nav import flags

FAULTS = (
    fault("sensor-turned", "U3", 15.0, 3.0, axis='"x"'),
    fault("spi-frozen", "accelerometer2", 24.0, 3.0),
    fault("i2c-bit-errors", "commands", 28.5, 3.2, probability=0.3),
    fault("pin-stuck", "SYNC", 32.0, 3.0, level="true"),
    fault("chip-busy", "U8", 38.0, 3.0, nack="true"),
    fault("chip-busy", "U8", 45.5, 2.5),
    fault("packet-loss", "packets", 50.0, 3.0),
    fault("i2c-stuck", "commands", 55.5, 3.2),
    fault("spi-swapped", "accelerometer1", 67.0, 0.3, **{"with": '"accelerometer4"'}),
)


def struck() -> Driven:
    return drive("static", "adxl345", "duration_s=72", f"fault=[{', '.join(FAULTS)}]")


def flagged(driven: Driven, flag: int, from_s: float, to_s: float) -> bool:
    """Whether all solutions between two times have a flag; fails unless all or none do."""
    t = driven.column("t_s")
    told = driven.column("flags")[(t >= from_s) & (t < to_s)].astype(int) >> flag & 1
    assert len(told) > 0
    assert told.min() == told.max()
    return bool(told[0])


def test_every_fault_strikes() -> None:
    assert [one.name for one in struck().result.faults if not one.fired] == []
    assert all(cpu.deadline_misses == cpu.overruns == 0 for cpu in struck().result.cpu)


def test_a_turned_chip_is_not_believed_from_its_first_sample() -> None:
    driven = struck()
    assert driven.said("accelerometer 3 at odds with the others", 15.0) < 15.0 + 1.0 + 1.2
    assert 18.0 < driven.said("accelerometer 3 no longer at odds", 15.0) < 18.0 + 1.3 + 1.2
    assert flagged(driven, flags.IMU_GAP, 15.2, 18.0)
    assert not flagged(driven, flags.IMU_GAP, 21.5, 24.0)
    assert driven.worst("error_roll_deg", 15.0, 24.0) < 4.0
    assert driven.worst("error_pitch_deg", 15.0, 24.0) < 4.0


def test_answers_that_no_longer_change_are_a_stuck_chip() -> None:
    driven = struck()
    assert driven.said("accelerometer 2 stuck", 24.0) < 24.1 + 1.2
    assert 27.0 < driven.said("accelerometer 2 no longer stuck", 24.0) < 28.3
    assert flagged(driven, flags.IMU_STUCK, 25.5, 27.0)
    assert not flagged(driven, flags.IMU_STUCK, 28.6, 32.0)


@pytest.mark.parametrize(("from_s", "to_s"), [(28.5, 31.7), (55.5, 58.7)])
def test_a_command_channel_that_spoils_or_hangs_is_told_and_nothing_else(from_s: float, to_s: float) -> None:
    driven = struck()
    assert from_s + 2.0 < driven.said("acquisition answers no command", from_s) < to_s
    assert to_s < driven.said("acquisition answers commands again", from_s) < to_s + 1.2
    told = [text for at_s, text in driven.words() if from_s < at_s < to_s]
    assert [text for text in told if text.startswith(("accelerometer", "compass:", "receiver"))] == []


@pytest.mark.parametrize("entries", [1, 2])
def test_a_fifo_that_is_never_empty_is_told(entries: int) -> None:
    lies = fault("spi-register", "accelerometer6", 3.0, 2.5, register=0x39, value=entries)
    driven = drive("static", "adxl345", "duration_s=9", f"fault=[{lies}]")
    assert 3.0 < driven.said("accelerometer 6 missing") < 5.2
    assert 5.5 < driven.said("accelerometer 6 no longer missing") < 8.7
    assert not any("accelerometer" in text and " 6 " not in text for _, text in driven.words())


def test_without_sync_line_packets_date_the_ticks() -> None:
    driven = struck()
    assert driven.said("sync line lost", 32.0) < 32.8
    assert 35.0 < driven.said("sync line is back", 32.0) < 35.8
    assert driven.worst("error_yaw_deg", 32.0, 38.0) < 2.0


def test_a_compass_within_its_delay_is_told() -> None:
    driven = struck()
    assert driven.said("compass: nobody answers", 38.0) < 40.0
    assert flagged(driven, flags.ATTITUDE_LOST, 40.3, 41.0)
    assert driven.said("compass: ok", 41.0) < 45.0
    assert not flagged(driven, flags.ATTITUDE_LOST, 46.0, 50.0)


def test_a_compass_that_gives_the_answer_before_is_told_and_waited_for() -> None:
    driven = struck()
    assert 45.5 < driven.said("compass: answers late", 45.5) < 48.0
    assert 48.0 < driven.said("compass: ok", 46.0) < 50.1
    (early,) = (event.text for event in driven.result.events if "read within the delay" in event.text)
    times = int(early.removesuffix(" times").rsplit(" ", 1)[1])
    assert 5 <= times <= 14, "of 25 readings in 2.5 s"


def test_after_a_pause_of_packets_the_board_aligns_again() -> None:
    driven = struck()
    assert driven.said("acquisition silent", 50.0) < 50.5
    assert driven.said("attitude lost, no packets for 3 s", 50.0) < 53.3
    assert 62.0 < driven.said("aligned: heading", 53.0) < 65.0
    assert driven.worst("error_roll_deg", 65.5, 67.0) < 3.0


def test_a_flag_stands_for_what_is_so() -> None:
    driven = struck()
    t, word = driven.column("t_s"), driven.column("flags").astype(int)
    assert not (word[(t > 12.0) & (t < 14.8)]).any()
    lost = t[(word >> flags.GNSS_LOST & 1) != 0]
    assert not len(lost) or (lost.min() > 50.0 and lost.max() < 55.0)


def test_a_receiver_that_is_cut_off_is_flagged_while_it_is() -> None:
    cut = fault("uart-cut", "gnss", 14.0, 8.0)
    driven = drive("static", "equivalent", "duration_s=26", f"fault=[{cut}]")
    assert not flagged(driven, flags.GNSS_LOST, 11.0, 16.0)
    assert flagged(driven, flags.GNSS_LOST, 17.6, 22.0)
    assert not flagged(driven, flags.GNSS_LOST, 23.6, 26.0)


def test_both_ends_of_the_packet_link_tell_what_their_dma_moved() -> None:
    buses = {bus.name: bus for bus in drive("chapter5", "equivalent", "duration_s=50").result.buses}
    for end in ("packets.fpga", "packets.dsp"):
        assert buses[end].bytes == 96 * buses[end].transactions


def test_samples_are_as_old_as_seven_free_clocks_make_them() -> None:
    metrics = drive("chapter5", "equivalent", "duration_s=50").result.metrics
    period_us = 5_000.0
    told = {name: metrics[name] for name in metrics if name.endswith("_us")}
    assert all(value is not None for value in told.values())
    oldest_of_seven = period_us * 7 / 8  # each uniform within its period
    assert told["sample_to_epoch_mean_us"] == pytest.approx(oldest_of_seven, abs=0.1 * period_us)
    assert oldest_of_seven < told["sample_to_epoch_max_us"] < 1.01 * period_us
    whole = told["sample_to_epoch_mean_us"] + told["epoch_to_line_mean_us"]
    assert told["age_of_data_mean_us"] == pytest.approx(whole, abs=1e-6)
    navigation = next(
        task for cpu in drive("chapter5", "equivalent", "duration_s=50").result.cpu for task in cpu.tasks
        if task.name == "navigation"
    )  # fmt: skip
    assert told["epoch_to_line_max_us"] > navigation.worst_response_us
    assert np.isfinite(told["age_of_data_p95_us"])
