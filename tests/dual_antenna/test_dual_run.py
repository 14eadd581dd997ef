"""The board end to end: two processors, frames and sentences in, solutions on the link out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from board_run import fault
from dual_runs import RECEIVER, drive

from host.replay.request import ReplayRequest
from host.replay.strict import replay_strict
from host.tables.second_antenna import receiver_heading_rms

SHORT = "duration_s=240"


def test_road_within_its_limits() -> None:
    driven = drive("road", SHORT)
    metrics, gnss = driven.result.metrics, driven.result.gnss
    assert metrics["aligned_at_s"] == pytest.approx(13.3, abs=0.5)
    assert metrics["position_horizontal_rms_m"] <= min(2.0, gnss["position_horizontal_rms_m"])
    assert metrics["velocity_rms_mps"] <= 0.05
    assert metrics["yaw_rms_deg"] <= 0.08
    assert metrics["pitch_rms_deg"] <= 0.03


def test_the_covariance_is_honest() -> None:
    """NEES of position, velocity and attitude: nine where errors are as large as claimed."""
    metrics = drive("road", SHORT).result.metrics
    assert 4.5 < metrics["nees_mean"] < 18.0
    assert metrics["roll_rms_deg"] < 0.004, "half a period of lag makes 0.0045"


def test_fused_heading_is_better_than_the_receiver_s() -> None:
    own = receiver_heading_rms("road", 1)
    assert own == pytest.approx(np.hypot(0.08, 0.06), rel=0.1), "white and slow part of a 2 m baseline"
    assert drive("road", SHORT).result.metrics["yaw_rms_deg"] < own


def test_a_cycle_fits_into_its_period() -> None:
    cpus = {cpu.name: cpu for cpu in drive("road", SHORT).result.cpu}
    assert set(cpus) == {"dsp", "fpga"}
    for cpu in cpus.values():
        assert cpu.deadline_misses == cpu.overruns == cpu.resets == 0
    tasks = {task.name: task for task in cpus["dsp"].tasks}
    assert tasks["navigation"].activations == pytest.approx(200 * 239.5 + 239, abs=10)
    assert tasks["navigation"].worst_response_us < 5000.0
    assert tasks["filter"].activations == pytest.approx(238, abs=1)
    front = {task.name: task for task in cpus["fpga"].tasks}
    assert front["timepulse"].activations == pytest.approx(238, abs=1)
    buses = {bus.name: bus for bus in drive("road", SHORT).result.buses}
    assert buses["imu.rx"].bytes == pytest.approx(32 * 200 * 239.5, abs=64)
    assert buses["exchange.dsp"].load < buses["imu.rx"].load < 0.3


def test_epochs_are_dated_by_the_pulse() -> None:
    gnss = drive("road", SHORT).result.gnss
    # one epoch comes before the first pulse and is dated by the nominal latency
    assert abs(gnss["time_tag_error_rms_s"]) < 0.0025


def test_capture_repeats_exactly(tmp_path: Path) -> None:
    out = tmp_path / "run"
    first = drive("static", "duration_s=25", out=out)
    again = drive("static", "duration_s=25")
    assert first.result.state_hash == again.result.state_hash
    replayed = replay_strict(ReplayRequest(out / "run.mcap"))
    assert replayed.ok
    assert replayed.difference is None
    assert replayed.bytes_compared > 25 * 1000


def test_another_seed_is_another_run() -> None:
    from host.record.result import RunRequest
    from host.run.runner import run

    other = run(RunRequest("dual_antenna", "static", seed=2, overrides=("duration_s=25",), capture=False))
    assert other.state_hash != drive("static", "duration_s=25").result.state_hash


def test_a_loss_is_bridged_and_joined_again() -> None:
    driven = drive("road", "duration_s=240", "outage=[{ start_s = 100.0, duration_s = 60.0 }]")
    (outage,) = driven.result.outages
    assert outage.horizontal_drift_m is not None
    assert 0.0 < outage.horizontal_drift_m < 6.0
    lost, back = driven.said("GNSS lost"), driven.said("GNSS is back")
    assert 100.0 < lost < 104.0
    assert 160.0 < back < 166.0
    assert not [text for at_s, text in driven.words() if at_s > 160.0 and "refused" in text]
    assert driven.worst("error_yaw_deg", 100.0, 240.0) < 0.15


def test_wrong_headings_are_refused() -> None:

    wrong = (
        fault("gnss-baseline-jump", RECEIVER, 100.0, 8.0, heading_deg=180.0),
        fault("gnss-baseline-jump", RECEIVER, 129.5, 1.0, heading_deg=5.0),
        fault("gnss-baseline-jump", RECEIVER, 150.0, 12.0, heading_deg=-5.0),
        fault("gnss-baseline-jump", RECEIVER, 180.0, 12.0, heading_deg=1.0, length_m=0.3),
    )
    driven = drive("road", SHORT, f"fault=[{', '.join(wrong)}]")
    assert [use.fired for use in driven.result.faults] == [8, 1, 12, 12]
    clean = drive("road", SHORT)
    assert driven.worst("error_yaw_deg", 60.0, 240.0) <= clean.worst("error_yaw_deg", 60.0, 240.0) + 0.05
    assert 100.0 <= driven.said("second antenna: heading refused, it is turned") < 102.0
    assert 129.0 <= driven.said("second antenna: angles refused", 120.0) < 132.0
    assert 180.0 <= driven.said("second antenna: refused, the baseline has a wrong length") < 182.0
    assert driven.said("second antenna is back", 190.0) < 194.0


def test_without_second_antenna_the_gyros_find_the_heading() -> None:

    lost = fault("gnss-baseline-lost", RECEIVER, 0.0)
    driven = drive("static", "duration_s=180", "profile.gyro_compass_s=100.0", f"fault=[{lost}]")
    told = [text for _, text in driven.words() if text.startswith("gyro-compass:")]
    sigmas = [float(text.split("1 sigma ")[1].split()[0]) for text in told]
    assert len(sigmas) == 3
    assert sigmas == sorted(sigmas, reverse=True)
    # 0.1 °/h of gyro bias over the level part of the Earth's rate
    assert 0.44 < sigmas[-1] < 0.8
    assert all(cpu.overruns == 0 for cpu in driven.result.cpu), "two lines in a row at the same moment"
    assert driven.said("heading from: gyro-compass") == pytest.approx(112.0, abs=15.0)
    assert driven.worst("error_yaw_deg", 130.0, 180.0) < 3.0 * sigmas[-1]
