"""`navtwin attitude` on written recordings: tables, JSON, layouts of files, and what people get wrong."""

import importlib.util
import json
import sys

import numpy as np
import pytest
from hand_motion import hand_motion
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

from host.attitude import peers
from host.attitude.estimates import Estimate
from host.attitude.scoring import east_north_up
from host.cli.main import app


def navtwin(*arguments):
    return CliRunner().invoke(app, ["attitude", *map(str, arguments)])


def arrays(seed=1):
    motion = hand_motion(seed=seed, moving_s=9.0)
    return {
        "imu_gyr": motion.omega,
        "imu_acc": motion.force,
        "imu_mag": motion.field,
        "opt_quat": east_north_up(motion.truth.as_quat(scalar_first=True)),
        "movement": motion.moves,
        "sampling_rate": np.array([[200.0]]),
    }


@pytest.fixture(scope="module")
def trial(tmp_path_factory):
    path = tmp_path_factory.mktemp("trials") / "hand.npz"
    np.savez(path, **arrays())
    return path


def figures(outcome):
    assert outcome.exit_code == 0, outcome.output
    return json.loads(outcome.stdout)


def test_one_table_of_one_run(trial, tmp_path):
    np.savez(tmp_path / "other.npz", **arrays(2))
    outcome = navtwin(trial, tmp_path / "other.npz", "--arithmetic", "float32,fixed,float64")
    assert outcome.exit_code == 0, outcome.output
    for word in (
        "hand",
        "other",
        "navtwin",
        "bmi160",
        "adis16407",
        "float64",
        "fixed",
        "mean of 2",
        "inclination",
    ):
        assert word in outcome.stdout
    for peer in peers.PEERS:
        assert (peer in outcome.stdout) == (importlib.util.find_spec(peer) is not None)


def test_figures_for_programs(trial):
    found = figures(navtwin(trial, "--json", "-", "-q", "--beside", "none"))
    assert found["format"] == "navtwin-attitude-1"
    by_feed = {result["feed"]: result for result in found["results"] if result["arithmetic"] == "float32"}
    assert set(by_feed) == {"direct", "bmi160", "adis16407"}
    assert by_feed["direct"]["total_rms_deg"] < 1.0
    assert by_feed["bmi160"]["total_rms_deg"] < 1.2
    assert by_feed["bmi160"]["saturation"]["samples"] == 0
    beyond = (np.abs(arrays()["imu_gyr"]) > np.radians(303.0)).any()
    assert (by_feed["adis16407"]["saturation"]["samples"] > 0) == beyond
    assert {mean["recordings"] for mean in found["means"]} == {1}


def test_all_layouts_give_the_same(trial, tmp_path):
    io = pytest.importorskip("scipy.io")
    h5py = pytest.importorskip("h5py")
    io.savemat(tmp_path / "hand.mat", {**arrays(), "movement": arrays()["movement"][:, None].astype(float)})
    with h5py.File(tmp_path / "hand.hdf5", "w") as file:
        for name, values in arrays().items():
            file[name] = values
    alone = ("--feed", "direct", "--beside", "none", "--json", "-", "-q")
    results = [
        figures(navtwin(path, *alone))["results"]
        for path in (trial, tmp_path / "hand.mat", tmp_path / "hand.hdf5")
    ]
    assert results[0] == results[1] == results[2]


def test_names_below_the_data_folder(trial, tmp_path):
    (tmp_path / "broad").mkdir()
    (tmp_path / "broad" / "hand.npz").write_bytes(trial.read_bytes())
    alone = ("--feed", "direct", "--beside", "none", "--json", "-", "-q", "--data", tmp_path)
    assert figures(navtwin("hand.npz", *alone)) == figures(navtwin(*alone))


def test_a_peer_that_is_not_installed_is_left_out(trial, monkeypatch):
    monkeypatch.setattr(peers, "find_spec", lambda _name: None)
    outcome = navtwin(trial, "--feed", "direct")
    assert outcome.exit_code == 0, outcome.output
    assert "vqf is not installed and left out: pip install vqf" in outcome.stderr
    assert "imufusion is not installed" in outcome.stderr
    assert "navtwin" in outcome.stdout


def test_a_rate_beyond_the_fixed_point_filter_is_told(tmp_path):
    data = arrays() | {"sampling_rate": np.array(10.0)}
    np.savez(tmp_path / "slow.npz", **data)
    outcome = navtwin(tmp_path / "slow.npz", "--feed", "direct", "--beside", "none")
    assert outcome.exit_code == 0, outcome.output
    assert "slow: fixed point left out: period is 0.1 s" in outcome.stderr


def test_an_estimate_that_is_none_has_no_figure(trial, monkeypatch):
    def nothing(_peer, recording):
        return Estimate(np.full((len(recording), 4), np.nan))

    monkeypatch.setattr("host.attitude.comparison.by_peer", nothing)
    monkeypatch.setattr(peers, "find_spec", lambda _name: True)
    outcome = navtwin(trial, "--feed", "direct", "--beside", "vqf", "--json", "-", "-q")
    found = figures(outcome)["results"]
    assert found[-1]["filter"] == "vqf"
    assert found[-1]["total_rms_deg"] is None


def test_gyro_delay_is_taken(trial):
    alone = ("--feed", "direct", "--beside", "none", "--arithmetic", "float32", "--json", "-", "-q")
    plain, ahead = (
        figures(navtwin(trial, *alone, "--gyro-delay", delay))["results"][0]["total_rms_deg"]
        for delay in ("0", "20")
    )
    assert ahead > 1.5 * plain


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"imu_mag": None}, "lacks imu_mag"),
        ({"opt_quat": None}, "lacks opt_quat"),
        ({"movement": None}, "lacks movement"),
        ({"sampling_rate": None}, "lacks sampling_rate_hz (or sampling_rate), e.g. 285.714"),
        ({"sampling_rate": np.array(0.0)}, "sampling rate 0 Hz"),
        ({"sampling_rate": np.array(np.nan)}, "sampling rate nan Hz"),
        ({"imu_gyr": np.zeros((5, 3))}, "imu_gyr has the shape (5, 3)"),
        ({"opt_quat": np.zeros((3000, 3))}, "opt_quat has the shape (3000, 3); wanted: (3000, 4)"),
        ({"movement": np.zeros(7)}, "movement has 7 values for 3000 samples"),
        ({"movement": np.zeros(3000)}, "nothing to score"),
        ({"opt_quat": np.full((3000, 4), np.nan)}, "nothing to score"),
        ({"imu_acc": np.full((3000, 3), np.nan)}, "imu_acc holds no number at all"),
        ({"imu_acc": np.full((3000, 3), 0.6)}, "it must be in m/s², about 9.8 at rest"),
        ({"imu_gyr": np.full((3000, 3), 300.0)}, "imu_gyr is about 300; it must be in rad/s"),
        ({"imu_gyr": np.full((3000, 3), 1j)}, "cannot be read as a NumPy archive: complex numbers"),
    ],
)
def test_wrong_arrays(tmp_path, change, message):
    data = {name: values for name, values in {**arrays(), **change}.items() if values is not None}
    np.savez(tmp_path / "wrong.npz", **data)
    outcome = navtwin(tmp_path / "wrong.npz")
    assert outcome.exit_code == 2
    assert message in outcome.stderr
    assert "Traceback" not in outcome.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("nothing.npz",), "nothing.npz: no such file"),
        (("--feed", "bmi106", "TRIAL"), "--feed bmi106: did you mean 'bmi160'?"),
        (("--beside", "vqg", "TRIAL"), "--beside vqg: did you mean 'vqf'?"),
        (("--beside", "none,vqf", "TRIAL"), "none stands alone"),
        (("--feed", ",", "TRIAL"), "--feed: names nothing"),
        (("--arithmetic", "float16", "TRIAL"), "--arithmetic float16"),
        (("--gyro-delay", "-1", "TRIAL"), "--gyro-delay -1: it lies in 0 … 100 ms"),
        (("--gyro-delay", "nan", "TRIAL"), "--gyro-delay nan"),
        (("--gyro-delay", "3", "TRIAL"), "--gyro-delay is known to the float filters only"),
        (("--json", "/no/such/place.json", "TRIAL"), "the folder /no/such does not exist"),
        (("--data", "/no/such", "hand.npz"), "--data /no/such: no such folder"),
    ],
)
def test_wrong_options(trial, arguments, message):
    outcome = navtwin(*(str(trial) if word == "TRIAL" else word for word in arguments))
    assert outcome.exit_code == 2
    assert message in outcome.stderr


@pytest.mark.parametrize("ending", ["npz", "mat", "hdf5", "csv"])
def test_files_that_are_none(tmp_path, ending):
    path = tmp_path / f"noise.{ending}"
    path.write_bytes(np.random.default_rng(1).bytes(3000))
    outcome = navtwin(path)
    assert outcome.exit_code == 2
    assert str(path) in outcome.stderr
    assert "Traceback" not in outcome.stderr


def test_no_recording_and_no_folder(monkeypatch):
    monkeypatch.delenv("NAVTWIN_DATA", raising=False)
    outcome = navtwin()
    assert outcome.exit_code == 2
    assert "no recording named" in outcome.stderr


def test_without_h5py_it_says_so(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "h5py", None)
    monkeypatch.setattr("host.attitude.recording.find_spec", lambda _name: None)
    (tmp_path / "hand.hdf5").write_bytes(b"")
    outcome = navtwin(tmp_path / "hand.hdf5")
    assert outcome.exit_code == 2
    assert "needs h5py, which is not installed: pip install h5py" in outcome.stderr


def test_rotations_of_the_written_trial_are_right():
    """The written reference is what scipy says."""
    q = Rotation.from_quat(arrays()["opt_quat"], scalar_first=True)
    up = hand_motion(moving_s=9.0).truth.inv().apply([0, 0, -1.0])
    assert q.inv().apply([0, 0, 1.0]) == pytest.approx(up, abs=1e-9)
