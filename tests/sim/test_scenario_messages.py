"""A wrong scenario gets one message: file, key, value, valid example."""

import pytest

from host.sim.scenario.errors import ScenarioError
from host.sim.scenario.load import load_scenario
from host.sim.scenario.overrides import apply_overrides
from host.sim.simulated import SimulatedVehicle

GOOD = """
duration_s = 60.0
segment = [{ kind = "rest", duration_s = 20.0 }, { kind = "reach-speed", duration_s = 8.0, to_mps = 10.0 }]
[place]
latitude_deg = 30.0
longitude_deg = 114.0
[gnss]
latency_s = 0.1
"""


def message(tmp_path, text, overrides=()):
    path = tmp_path / "mine.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ScenarioError) as caught:
        load_scenario(path, overrides)
    assert "\n" not in str(caught.value)
    return str(caught.value)


CASES = {
    "malformed": (GOOD.replace("= 0.1", "== 0.1"), ["mine.toml", "not valid TOML", "line"]),
    "unknown key": (
        GOOD.replace("latency_s", "latancy_s"),
        ["unknown key gnss.latancy_s = 0.1", "did you mean 'latency_s'"],
    ),
    "unit": (
        GOOD.replace("duration_s = 60.0", "duration_min = 1"),
        ["duration_min = 1", "seconds", "duration_s = 1200.0"],
    ),
    "no unit": (
        GOOD.replace("duration_s = 60.0", "duration = 60"),
        ["duration = 60", "seconds", "duration_s = 1200.0"],
    ),
    "text": (
        GOOD.replace("60.0", '"20 min"'),
        ['duration_s = "20 min"', "finite number of seconds", "1200.0"],
    ),
    "negative": (GOOD.replace("60.0", "-60.0"), ["duration_s = -60.0", "must be greater than 0", "1200.0"]),
    "nan": (GOOD.replace("0.1", "nan"), ["gnss.latency_s", "NaN", "finite number of seconds", "0.08"]),
    "inf": (GOOD.replace("0.1", "inf"), ["gnss.latency_s", "finite number"]),
    "boolean": (GOOD.replace("0.1", "true"), ["gnss.latency_s = true", "finite number of seconds"]),
    "kind": (GOOD.replace('"rest"', '"rset"'), ["segment[1]", 'kind = "rset"', "did you mean 'rest'"]),
    "no kind": (GOOD.replace('kind = "rest", ', ""), ["segment[1]", "kind is missing", 'kind = "turn"']),
    "in a segment": (GOOD.replace("to_mps", "to_kmh"), ["segment[2].to_kmh = 10.0", "m/s", "to_mps = 12.0"]),
    "overlapping segments": (
        GOOD.replace('"reach-speed",', '"reach-speed", start_s = 10.0,'),
        ["segment[2]", "start_s = 10.0", "so that none overlap", "for example segment = "],
    ),
    "missing in a segment": (
        GOOD.replace(", to_mps = 10.0", ""),
        ["segment[2].to_mps is missing", "to_mps = 12.0"],
    ),
    "single brackets": (
        GOOD + '[fault]\nkind = "uart-cut"\ntarget = "U3"\nat_s = 1.0',
        ["fault", "must be a list", "[[…]]"],
    ),
    "latitude": (GOOD.replace("30.0", "95.0"), ["place.latitude_deg = 95.0", "89", "30.5278"]),
    "table": (
        GOOD.replace("[gnss]\nlatency_s = 0.1", "").replace("duration_s = 60.0", "gnss = 3"),
        ["gnss = 3", "table"],
    ),
    "preset": (GOOD + '[imu]\npreset = "bmi170"', ["imu", "no sensor error preset 'bmi170'", "bmi160"]),
    "per axis": (GOOD + "[imu.gyro]\nbias_dps = [1.0, 2.0]", ["imu.gyro.bias_dps", "[1.0, 2.0]", "3"]),
    "negative sigma": (
        GOOD + "[imu.gyro]\nturn_on_bias_dps = -0.5",
        ["imu.gyro.turn_on_bias_dps = -0.5", "negative", "0.5"],
    ),
    "utc": (
        GOOD + '[start]\nutc = "14.5.2024"',
        ["start.utc", "14.5.2024", "ISO 8601", "2024-05-14T08:00:00Z"],
    ),
    "zone": (GOOD + '[start]\nutc = "2024-05-14T08:00:00+02:00"', ["start.utc", "UTC", "Z"]),
    "limit": (GOOD + '[expect.metrics]\nyaw_rms_deg = "< 2"', ["expect", "yaw_rms_deg", "< 2", "<= 2.5"]),
    "nothing moves": (
        "[place]\nlatitude_deg = 1.0\nlongitude_deg = 2.0",
        ["duration_s or motion", 'kind = "rest"'],
    ),
    "no place": ("duration_s = 5.0", ["[place]", "latitude_deg"]),
    "no recording": ('kind = "recording"', ["[recording]", "comma2k19/example_1.npz"]),
    "name": (GOOD.replace("duration_s = 60.0", 'name = "x"'), ["name", "named by its file"]),
    "both": (GOOD + "[trajectory]\nmatrix = [[1, 5, 0, 0]]", ["twice", "segment", "trajectory.matrix"]),
    "band": (
        GOOD + "[vibration]\nlow_hz = 9.0\nhigh_hz = 5.0",
        ["vibration", "high_hz = 5 must lie above low_hz = 9"],
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_the_message_says_what_where_value_and_example(case, tmp_path):
    text, parts = CASES[case]
    said = message(tmp_path, text)
    assert said.startswith(str(tmp_path))
    for part in parts:
        assert part in said


def test_a_good_scenario_loads(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(GOOD)
    scenario = load_scenario(path)
    assert scenario.name == "mine"
    assert scenario.duration_s == 60.0
    assert scenario.gnss.latency_s == 0.1
    assert scenario.path == path


def test_a_missing_file_tells_what_lies_beside_it(tmp_path):
    (tmp_path / "town.toml").write_text(GOOD)
    with pytest.raises(ScenarioError, match=r"twon.toml: no such scenario file; scenarios there: town"):
        load_scenario(tmp_path / "twon.toml")


def test_inheritance_merges_tables_and_replaces_lists(tmp_path):
    (tmp_path / "base.toml").write_text(GOOD + "[[outage]]\nstart_s = 5.0\nduration_s = 1.0")
    (tmp_path / "child.toml").write_text(
        'inherit = "base"\n[gnss]\nvertical_factor = 2.0\n[[outage]]\nstart_s = 9.0\nduration_s = 2.0'
    )
    child = load_scenario(tmp_path / "child.toml")
    assert (child.gnss.latency_s, child.gnss.vertical_factor) == (0.1, 2.0)
    assert [o.start_s for o in child.outage] == [9.0]
    assert len(child.segment) == 2


def test_inheritance_in_a_circle_is_shown(tmp_path):
    (tmp_path / "a.toml").write_text('inherit = "b"')
    (tmp_path / "b.toml").write_text('inherit = "a"')
    with pytest.raises(ScenarioError, match="a → b → a"):
        load_scenario(tmp_path / "a.toml")


def test_a_missing_parent_names_its_heir(tmp_path):
    (tmp_path / "a.toml").write_text('inherit = "nobody"')
    with pytest.raises(ScenarioError, match=r"nobody.toml: no such scenario file \(inherited by a.toml\)"):
        load_scenario(tmp_path / "a.toml")


def test_overrides_reach_tables_lists_and_new_tables():
    data = {"gnss": {"latency_s": 0.08}, "outage": [{"start_s": 1.0, "duration_s": 2.0}]}
    changed = apply_overrides(
        data,
        [
            "gnss.latency_s=0.1",
            "outage.0.duration_s = 30",
            "imu.gyro.bias_dps=[1, 2, 3]",
            "imu.preset=bmi160",
            'start.utc="x"',
        ],
    )
    assert changed == {
        "gnss": {"latency_s": 0.1},
        "outage": [{"start_s": 1.0, "duration_s": 30}],
        "imu": {"gyro": {"bias_dps": [1, 2, 3]}, "preset": "bmi160"},
        "start": {"utc": "x"},
    }
    assert data["gnss"]["latency_s"] == 0.08


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("gnss.latency_s", "must be key=value"),
        ("=3", "must be key=value"),
        ("gnss..x=3", "must be key=value"),
        ("gnss.latency_s.x=3", "'latency_s' is a value (0.1), not a table"),
        ("segment.9.duration_s=3", "'9' is not an entry of this list (entries: 0 … 1)"),
        ("gnss.latancy_s=3", "unknown key gnss.latancy_s = 3; did you mean 'latency_s'?"),
        ("gnss.latency_s=fast", 'gnss.latency_s = "fast": must be a finite number of seconds'),
    ],
)
def test_a_wrong_override_is_explained(override, said, tmp_path):
    assert said in message(tmp_path, GOOD, [override])


def test_rest_at_speed_names_the_file(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(GOOD.replace("]\n[place]", ', { kind = "rest", duration_s = 5.0 }]\n[place]'))
    with pytest.raises(ScenarioError, match=r"mine.toml: .*kind 'rest' begins at 10 m/s"):
        SimulatedVehicle(load_scenario(path), 1)


@pytest.mark.parametrize(
    ("row", "said"),
    [
        ("[7, -8, 0, 90]", "row 2 [7, -8, 0, 90]: duration_s must be greater than 0"),
        ("[12, 8]", "row 2 [12, 8]: type code 12 is not one of 1 … 10, 91"),
        ("[5, 8, 1.0, 0]", "row 2 [5, 8, 1, 0]: period_s must be greater than 0"),
        ("[5, 8, 1.0]", "row 2 [5, 8, 1]: type 5 needs 4 columns"),
        ("[7]", "trajectory.matrix[2] = [7]"),
    ],
)
def test_a_wrong_row_of_the_matrix_is_shown(row, said, tmp_path):
    text = f"[place]\nlatitude_deg = 1.0\nlongitude_deg = 2.0\n[trajectory]\nmatrix = [[1, 5], {row}]"
    assert said in message(tmp_path, text)


def test_limits_are_flat_and_may_name_a_figure(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(
        GOOD
        + '[expect]\n"metrics.nees_mean" = ">= 4.5"\n[expect.metrics]\nyaw_rms_deg = 1.5\n'
        + 'position_horizontal_rms_m = "<= gnss.position_horizontal_rms_m"\n'
    )
    expect = load_scenario(path).expect
    assert (expect["metrics.nees_mean"].relation, expect["metrics.nees_mean"].value) == (">=", 4.5)
    assert (expect["metrics.yaw_rms_deg"].relation, expect["metrics.yaw_rms_deg"].value) == ("<=", 1.5)
    named = expect["metrics.position_horizontal_rms_m"]
    assert (named.value, named.name) == (None, "gnss.position_horizontal_rms_m")


def test_toml_times_are_welcome(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(GOOD + "[start]\nutc = 2024-05-14T08:00:00Z")
    assert load_scenario(path).start.gps_time_ns == (16_200 * 86_400 + 8 * 3600 + 18) * 10**9
