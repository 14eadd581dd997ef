"""`navtwin simulate`: formats that other libraries read alike, exact instants, streamed and atomic."""

from __future__ import annotations

import errno
import json
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from numpy.typing import NDArray
from scipy.integrate import simpson
from typer.testing import CliRunner, Result

from host.cli.main import app
from host.sim.scenario.load import load_scenario
from host.sim.world import World

DRIVE = """
duration_s = 30.0
segment = [
  { kind = "rest", duration_s = 5.0 },
  { kind = "reach-speed", duration_s = 5.0, to_mps = 12.0 },
  { kind = "turn", duration_s = 8.0, angle_deg = 90.0, pitch_to_deg = 3.0 },
]
[place]
latitude_deg = 47.05
longitude_deg = 8.31
height_m = 440.0
[vibration]
z_mps2 = 1.0
[[outage]]
start_s = 20.0
duration_s = 5.0
"""
PERFECT = ("--set", "imu.preset=perfect")


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    path = tmp_path / "drive.toml"
    path.write_text(DRIVE)
    return path


def simulate(*arguments: object) -> Result:
    return CliRunner().invoke(app, ["simulate", *[str(one) for one in arguments]])


def made(scenario: Path, name: str, *more: object) -> Path:
    path = scenario.parent / name
    result = simulate(scenario, "-o", path, *more)
    assert result.exit_code == 0, result.output
    return path


def npz(scenario: Path, *more: object) -> Any:
    return np.load(made(scenario, "drive.npz", *more))


def table(path: Path, delimiter: str | None = ",") -> NDArray[np.float64]:
    found: NDArray[np.float64] = np.genfromtxt(path, delimiter=delimiter, skip_header=delimiter is not None)
    return found


def test_samples_are_those_that_the_chips_of_a_board_would_feel(scenario: Path) -> None:
    data = npz(scenario, "--seed", 3)
    imu = World(load_scenario(scenario), 3).imu("imu")
    felt = imu.sample(data["imu"]["t_ns"], 100.0)
    np.testing.assert_array_equal(data["imu"]["force"], felt[:, :3])
    np.testing.assert_array_equal(data["imu"]["rate"], felt[:, 3:6])
    assert (len(data["imu"]), data["imu"]["t_ns"][-1]) == (6001, 30_000_000_000)
    about = json.loads(str(data["about"]))
    assert (about["samples"], about["seed"], about["samples_are"]) == (6001, 3, "instant")


def test_all_formats_tell_the_same_drive(scenario: Path) -> None:
    data = npz(scenario)
    imu, gnss = data["imu"], data["gnss"]
    degrees = np.degrees([imu["latitude"], imu["longitude"]]).T
    truth = np.column_stack((degrees, imu["height"], imu["velocity"]))
    angles = np.degrees([imu["yaw"], imu["pitch"], imu["roll"]]).T
    csv = table(made(scenario, "drive.csv"))
    np.testing.assert_allclose(csv[:, 1:7], np.hstack((imu["force"], imu["rate"])), atol=1e-12)
    np.testing.assert_allclose(csv[:, 8:], np.hstack((truth, angles)), rtol=0, atol=6e-8)
    np.testing.assert_allclose(
        table(scenario.parent / "drive.gnss.csv")[:, 2], gnss["latitude_deg"], atol=1e-9
    )

    theirs = made(scenario, "ins.csv", "--format", "pyins").with_suffix("")
    pyins = table(theirs.with_suffix(".imu.csv"))
    np.testing.assert_allclose(
        pyins, np.column_stack((imu["t_ns"] / 1e9, imu["rate"], imu["force"])), atol=1e-12
    )
    fixed = gnss[gnss["fix"] == 1]
    assert len(table(theirs.with_suffix(".gnss.csv"))) == len(fixed) == 31 - 7

    messages: dict[str, list[dict[str, float]]] = {"/imu": [], "/truth": [], "/gnss": []}
    with made(scenario, "drive.mcap").open("rb") as file:
        for _schema, channel, message in make_reader(file).iter_messages():
            messages[channel.topic].append(json.loads(message.data))
    assert [len(rows) for rows in messages.values()] == [6001, 6001, 31]
    assert messages["/imu"][4321]["rate_y_radps"] == pytest.approx(imu["rate"][4321, 1], abs=1e-14)
    assert messages["/truth"][4321]["yaw_deg"] == pytest.approx(angles[4321, 0], abs=1e-9)
    assert messages["/gnss"][22]["latitude_deg"] is None


def test_kf_gins_files_hold_increments_in_seconds_of_week(scenario: Path) -> None:
    made(scenario, "k.txt", "--format", "kf-gins")
    imu, gnss, truth = (table(scenario.parent / f"k.{kind}.txt", None) for kind in ("imu", "gnss", "truth"))
    assert (imu.shape, gnss.shape, truth.shape) == ((6000, 7), (24, 7), (6000, 11))
    tuesday = 2 * 86400 + 8 * 3600 + 18  # 2024-05-14 08:00:00 UTC, 18 leap seconds, GPS week 2314
    assert (imu[0, 0], gnss[0, 0], truth[0, 0]) == (tuesday + 0.005, tuesday, 2314)
    np.testing.assert_array_equal(truth[:, 1], imu[:, 0])
    same = npz(scenario, "--samples", "increment")["imu"]
    np.testing.assert_allclose(imu[:, 1:], np.hstack((same["dtheta"], same["dv"])), atol=1e-12)


def test_increments_are_the_integral_of_what_a_perfect_sensor_feels(scenario: Path) -> None:
    """Against Simpson's rule on sixteen times as many instants."""
    increments = npz(scenario, "--samples", "increment", *PERFECT)["imu"]
    fine = npz(scenario, "--rate", 3200, *PERFECT)["imu"]
    for k in (0, 1100, 2345, 5999):
        part = slice(16 * k, 16 * k + 17)
        for name, rate in (("dtheta", "rate"), ("dv", "force")):
            wanted = simpson(fine[rate][part], dx=1 / 3200, axis=0)
            np.testing.assert_allclose(increments[name][k], wanted, rtol=1e-9, atol=1e-13)
    means = npz(scenario, "--samples", "mean", *PERFECT)["imu"]
    np.testing.assert_allclose(means["rate"] * 0.005, increments["dtheta"], rtol=1e-12)


def test_noise_of_increments_is_that_of_the_density(scenario: Path) -> None:
    more = ("--samples", "increment", "--set", "duration_s=200.0", *PERFECT)
    noisy = npz(scenario, *more, "--set", "imu.gyro.noise_dps_per_rthz=0.01")["imu"]
    plain = npz(scenario, *more)["imu"]
    noise = np.degrees(noisy["dtheta"] - plain["dtheta"])
    assert noise.std() == pytest.approx(0.01 * np.sqrt(100.0) * 0.005, rel=0.01)


def test_instants_of_a_rate_that_does_not_divide_a_second(scenario: Path) -> None:
    times = npz(scenario, "--rate", "819.2")["imu"]["t_ns"]
    exact = [k * 1_000_000_000 / Fraction("819.2") for k in range(len(times))]
    assert times.tolist() == [int(t) for t in exact]
    assert len(times) == int(30 * Fraction("819.2")) + 1


def test_blocks_leave_no_trace(scenario: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("a.npz", "a.csv", "a.mcap"):
        whole = made(scenario, name).read_bytes()
        monkeypatch.setattr("host.simulate.stream.BLOCK", 100)
        again = made(scenario, name).read_bytes()
        monkeypatch.undo()
        if name != "a.mcap":  # whose messages are in the order in which they came
            assert whole == again, name
        assert made(scenario, name).read_bytes() == whole, name
        assert made(scenario, name, "--seed", 2).read_bytes() != whole, name


def test_a_lever_arm_moves_the_receiver_only(scenario: Path) -> None:
    plain, moved = npz(scenario), npz(scenario, "--antenna", "2,0,0")
    np.testing.assert_array_equal(plain["imu"], moved["imu"])
    north = (moved["gnss"]["latitude_deg"][3] - plain["gnss"]["latitude_deg"][3]) * 111_000
    assert north == pytest.approx(2.0, rel=0.01)


def test_figures_for_programs_and_without_a_file(scenario: Path) -> None:
    result = simulate(scenario, "--json", "-", "--gnss-rate", 0)
    told = json.loads(result.stdout)
    assert (told["samples"], told["gnss_epochs"], told["files"]) == (6001, 0, [])
    assert told["samples_per_s"] == pytest.approx(told["samples"] / told["wall_s"])
    assert simulate("town-open", "--set", "duration_s=1.0", "-q").exit_code == 0
    assert sorted(path.name for path in scenario.parent.iterdir()) == ["drive.toml"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["no-such"], "no board has such a scenario"),
        (["./no.toml"], "no such scenario file"),
        (["real-drive"], "is a recording"),
        (["DRIVE", "-o", "x.doc"], "ending tells no format"),
        (["DRIVE", "-f", "csv"], "needs a file"),
        (["DRIVE", "-o", "x.csv", "-f", "cvs"], "did you mean 'csv'"),
        (["DRIVE", "-o", "x.txt", "-f", "kf-gins", "--samples", "instant"], "increments only"),
        (["DRIVE", "--samples", "mena"], "did you mean 'mean'"),
        (["DRIVE", "--rate", "0"], "--rate 0: must lie in"),
        (["DRIVE", "--rate", "nan"], "is not a number"),
        (["DRIVE", "--rate", "1e9"], "must lie in"),
        (["DRIVE", "--gnss-rate", "-1"], "must lie in"),
        (["DRIVE", "--antenna", "1,2"], "three lengths"),
        (["DRIVE", "--antenna", "1,2,inf"], "within ±100 m"),
        (["DRIVE", "--seed", "-1"], "--seed -1"),
        (["DRIVE", "-o", "no/such/x.csv"], "does not exist"),
        (["DRIVE", "--set", "imu.preset=bmi106"], "bmi160"),
        (["DRIVE", "--set", "segment.1.to_mps=inf"], "to_mps"),
        (["DRIVE", "--set", "segment.1.duration_s=-5"], "duration_s"),
    ],
)
def test_bad_input_is_one_message_and_leaves_nothing(
    scenario: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], words: str
) -> None:
    monkeypatch.chdir(scenario.parent)
    result = simulate(*(str(scenario) if one == "DRIVE" else one for one in arguments))
    assert result.exit_code == 2, result.output
    assert words in result.stderr
    assert result.stderr.count("\n") == 1
    assert sorted(path.name for path in scenario.parent.iterdir()) == ["drive.toml"]


@pytest.mark.parametrize("error", [OSError(errno.ENOSPC, "No space left on device"), KeyboardInterrupt()])
@pytest.mark.parametrize("name", ["x.csv", "x.npz", "x.mcap"])
def test_no_half_file_is_left(
    scenario: Path, monkeypatch: pytest.MonkeyPatch, error: BaseException, name: str
) -> None:
    before = b"of an earlier drive"
    (scenario.parent / name).write_bytes(before)

    def fails(*_: object) -> None:
        raise error

    monkeypatch.setattr("host.simulate.job.gnss_rows", fails)
    result = simulate(scenario, "-o", scenario.parent / name)
    assert result.exit_code == (2 if isinstance(error, OSError) else 130)
    assert "Traceback" not in result.output
    assert (scenario.parent / name).read_bytes() == before
    assert sorted(path.name for path in scenario.parent.iterdir()) == ["drive.toml", name]


@pytest.mark.filterwarnings("ignore:The copy keyword is deprecated")
def test_python_ins_reads_its_format_and_comes_back_to_the_truth(scenario: Path) -> None:
    pd = pytest.importorskip("pandas")
    strapdown = pytest.importorskip("pyins.strapdown")
    smooth = ("--set", "vibration.z_mps2=0.0", "--samples", "increment", *PERFECT)
    base = made(scenario, "ins.csv", "--format", "pyins", *smooth).with_suffix("")
    imu, truth = (
        pd.read_csv(base.with_suffix(f".{kind}.csv"), index_col="time") for kind in ("imu", "truth")
    )
    steps = strapdown.compute_increments_from_imu(imu, "increment")
    end = strapdown.Integrator(truth.iloc[0]).integrate(steps).iloc[-1]
    assert abs(end.lat - truth.lat.iloc[-1]) * 111_000 < 1e-3
    assert abs(end.lon - truth.lon.iloc[-1]) * 111_000 < 1e-3
    assert abs(end.heading - truth.heading.iloc[-1]) < 1e-6
