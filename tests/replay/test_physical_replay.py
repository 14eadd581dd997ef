"""Physical replay: other settings on the same road; what chips feel is what was measured."""

import json
import math

import numpy as np
import pytest
from replay_captures import captured
from typer.testing import CliRunner

from boards.places import board_folder
from host.capture.blocks import SpiTransaction
from host.capture.inertial_samples import Bmi160Traffic
from host.capture.reader import CaptureReader, Decoded
from host.cli.main import app
from host.replay.physical import replay_physical
from host.replay.request import ReplayRequest
from host.replay.run_difference import compare_runs
from host.sim.scenario.load import load_scenario
from host.sim.world import World

ROAD = "duration_s=170"


def test_samples_are_those_that_the_chip_felt():
    capture, _ = captured("full-rate", ROAD)
    traffic = Bmi160Traffic()
    traffic.add(r for r in CaptureReader(capture) if isinstance(r, SpiTransaction))
    samples = traffic.samples()
    steps = np.diff(samples.times_ns)
    assert np.median(steps) == pytest.approx(
        10_000_000 / 1.005, rel=1e-4
    )  # the board's chip runs 5000 ppm fast
    assert len(steps) > 16_000
    scenario = load_scenario(board_folder("car_mems") / "scenarios" / "town-open.toml", [ROAD])
    truth = World(scenario).truth(samples.times_ns)
    # Gravity minus what the hill and the drive make of it: chip z points up.
    still = slice(50, 1000)
    assert samples.force[still, 2].mean() == pytest.approx(9.8, abs=0.6)
    # The turn: rate of yaw against the truth's, chip z is body −z.
    yaw_rate = np.gradient(np.unwrap(truth.yaw), samples.times_ns / 1e9)
    smooth = np.ones(50) / 50
    felt = np.convolve(-samples.rate[:, 2], smooth, "same")
    assert np.std(yaw_rate) > math.radians(1.0)
    assert np.corrcoef(felt[100:-100], np.convolve(yaw_rate, smooth, "same")[100:-100])[0, 1] > 0.995


def traffic_of(*exchanges):
    traffic = Bmi160Traffic()
    traffic.add(
        SpiTransaction("spi", t, t + 1000, bytes.fromhex(mosi), bytes.fromhex(miso))
        for t, mosi, miso in exchanges
    )
    return traffic.samples()


BURST = "8c" + "00" * 15


def answer(gyro, accel, ticks):
    counts = b"".join(int(v).to_bytes(2, "little", signed=True) for v in (*gyro, *accel))
    return "00" + counts.hex() + ticks.to_bytes(3, "little").hex()


def test_scales_follow_the_ranges_of_the_fact_sheet():
    samples = traffic_of(
        (1_000_000_000, BURST, answer((164, 0, 0), (16384, 0, 0), 25_600)),
        (1_001_000_000, "4105", "0000"),  # 4 g
        (1_002_000_000, "4304", "0000"),  # 125 °/s
        (1_010_000_000, BURST, answer((2624, 0, 0), (8192, 0, 0), 25_600 + 256)),
        (1_011_000_000, "7eb6", "0000"),  # soft reset: 2 g, 2000 °/s again
        (1_020_000_000, BURST, answer((164, 0, 0), (16384, 0, 0), 25_600 + 512)),
    )
    assert samples.force[:, 0] == pytest.approx([9.80665] * 3)
    assert samples.rate[:, 0] == pytest.approx([math.radians(10.0)] * 3, rel=1e-6)
    assert samples.times_ns.tolist() == [1_000_000_000, 1_010_000_000, 1_020_000_000]


def test_a_capture_shows_its_sensor_and_positions_to_people():
    capture, _ = captured("full-rate", ROAD)
    traffic, shown, fixes, last = Bmi160Traffic(), [], [], None
    solutions = {}
    for record in CaptureReader(capture):
        if isinstance(record, SpiTransaction):
            traffic.add([record])
        elif isinstance(record, Decoded) and record.topic == "/imu/U2":
            shown.append(record.value)
        elif isinstance(record, Decoded) and record.topic == "/fix/solution":
            fixes.append(record.value)
        elif isinstance(record, Decoded) and record.topic == "/solution":
            solutions[round(record.value["t_s"], 6)] = record.value
    samples = traffic.samples()
    assert len(shown) > shown[-1]["t_s"]  # more than one a second
    for row in shown:
        k = int(np.argmin(np.abs(samples.times_ns / 1e9 - row["t_s"])))
        assert samples.times_ns[k] / 1e9 == pytest.approx(row["t_s"], abs=1e-6)
        assert row["force_z_mps2"] == pytest.approx(samples.force[k, 2], abs=1e-4)
        assert row["rate_z_dps"] == pytest.approx(math.degrees(samples.rate[k, 2]), abs=1e-4)
    assert len(fixes) > 80
    for fix in fixes:
        last = solutions[round(fix["timestamp"]["sec"] + fix["timestamp"]["nsec"] / 1e9, 6)]
        assert (fix["latitude"], fix["altitude"]) == (last["latitude_deg"], last["height_m"])
        assert fix["position_covariance"][0] == pytest.approx(last["sigma_east_m"] ** 2, rel=1e-3)


def test_a_late_read_is_dated_back_and_a_second_one_is_none():
    samples = traffic_of(
        (1_000_000_000, BURST, answer((1, 2, 3), (4, 5, 6), 25_600 + 128)),
        (1_004_000_000, BURST, answer((1, 2, 3), (4, 5, 6), 25_600 + 230)),
        (1_006_000_000, BURST, "ff" * 16),
    )
    assert samples.times_ns.tolist() == [995_000_000]


@pytest.mark.parametrize(("recorded", "wanted"), [("full-rate", "thesis"), ("thesis", "full-rate")])
def test_another_profile_on_the_same_road_is_as_good_as_if_it_had_driven_there(recorded, wanted):
    capture, _ = captured(recorded, ROAD)
    _, driven = captured(wanted, ROAD)
    replayed = replay_physical(ReplayRequest(capture, profile=wanted))
    assert replayed.scored_against == "truth"
    assert replayed.result.profile == wanted
    for figure, allowed in (
        ("position_horizontal_rms_m", 0.3),
        ("velocity_rms_mps", 0.05),
        ("pitch_rms_deg", 0.15),
        ("yaw_rms_deg", 0.3),
    ):
        assert replayed.result.metrics[figure] == pytest.approx(driven.metrics[figure], abs=allowed), figure
    assert replayed.result.gnss["position_horizontal_rms_m"] == pytest.approx(
        driven.gnss["position_horizontal_rms_m"], abs=0.02
    )


def test_the_command_writes_a_run_folder_that_replays_in_turn(tmp_path):
    capture, _ = captured("full-rate", "duration_s=100")
    runner = CliRunner()
    board = str(board_folder("car_mems"))
    arguments = ["replay", str(capture), "--mode", "physical", "-p", "thesis", "--board", board]
    arguments += ["--out", str(tmp_path / "p")]
    outcome = runner.invoke(app, [*arguments, "--json", str(tmp_path / "x.json"), "-q"])
    assert outcome.exit_code == 0, outcome.output
    document = json.loads((tmp_path / "x.json").read_text())
    assert (document["mode"], document["profile"]) == ("physical", "thesis")
    again = runner.invoke(app, ["replay", str(tmp_path / "p")])
    assert again.exit_code == 0, again.output
    assert document["state_hash"] in again.output


def test_two_equal_runs_do_not_differ_and_two_unlike_ones_part_where_they_part():
    first, _ = captured("full-rate", "duration_s=100")
    second, _ = captured("full-rate", "duration_s=100", "gnss.latency_s=0.12")
    assert compare_runs(first, first).same
    found = compare_runs(first, second)
    assert not found.same
    assert "overrides" in found.facts
    assert found.divergences[0].wire == "/uart/gnss/rx"
    times = [one.time_ns for one in found.divergences]
    assert times == sorted(times)
    assert found.stages[-1].max["horizontal_m"] > 0.001
    assert found.exceeds["10"] is None
    outcome = CliRunner().invoke(app, ["diff", str(first), str(second)])
    assert outcome.exit_code == 1
    assert "/uart/gnss/rx parts at" in outcome.output
    assert CliRunner().invoke(app, ["diff", str(first.parent), str(first)]).exit_code == 0
