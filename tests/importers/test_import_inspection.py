"""What is found in rows: against a plain loop, and case by case."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from host.importers.findings import Findings, Kind
from host.importers.inspection import Inspection
from host.importers.series import Rows, in_line
from host.importers.topics import epochs, samples
from host.importers.unit_checks import InertialUnits, MotionUnits, UnitRefusedError
from host.importers.units import Unit
from host.record.errors import UserError

NS = 1_000_000_000


def rows_of(series, times_ns, values, first=1):
    return Rows(
        series,
        np.array(times_ns, dtype=np.int64),
        np.array(values, dtype=float),
        np.arange(first, first + len(times_ns)),
    )


def still(n, seed=0):
    """Samples of a sensor at rest, in °/s and m/s²."""
    noise = np.random.default_rng(seed).standard_normal((n, 7)) * 0.01
    return noise + np.array([0, 0, 0, 0, 0, -9.8, 20.0])


def inspected(series, times_ns, values, cut=(), findings=None):
    """(kept times, findings) when the rows come in portions cut at `cut`."""
    findings = findings or Findings()
    inspection = Inspection(series, findings)
    kept = []
    edges = [0, *sorted(cut), len(times_ns)]
    for begin, end in pairwise(edges):
        if end > begin:
            part = rows_of(series, times_ns[begin:end], values[begin:end], begin + 1)
            kept += inspection.take(part).times_ns.tolist()
    rest = inspection.finish()
    if rest is not None:
        kept += rest.times_ns.tolist()
    return kept, {finding.kind: finding for finding in findings.all}


SERIES = samples("imu", "x.csv", in_line)


def test_sound_rows_all_come_through():
    kept, found = inspected(SERIES, [k * 10_000_000 for k in range(500)], still(500), cut=(7, 100, 101))
    assert len(kept) == 500
    assert found == {}


@given(
    st.lists(st.integers(-3, 40), min_size=3, max_size=60),
    st.lists(st.integers(0, 60), max_size=5, unique=True),
)
def test_what_is_kept_rises_and_does_not_depend_on_portions(steps, cuts):
    times = np.cumsum([100 * NS, *(step * 100_000_000 for step in steps)]).tolist()
    values = still(len(times))
    try:
        whole, found = inspected(SERIES, times, values)
    except UserError:
        with pytest.raises(UserError, match="does not go on"):
            inspected(SERIES, times, values, cut=[c for c in cuts if c < len(times)])
        return
    assert whole == sorted(set(whole))
    assert set(whole) <= set(times)
    counted = sum(found[k].count for k in (Kind.BACK, Kind.DUPLICATE, Kind.JUMP) if k in found)
    assert len(whole) + counted == len(times)
    if not any(kind is Kind.JUMP for kind in found):
        parts, _ = inspected(SERIES, times, values, cut=[c for c in cuts if c < len(times)])
        assert parts == whole


def test_one_row_far_ahead_is_the_wrong_one_not_all_behind_it():
    times = [k * 10_000_000 for k in range(300)]
    times[150] += 3600 * NS
    kept, found = inspected(SERIES, times, still(300), cut=(151,))
    assert len(kept) == 299
    assert found[Kind.JUMP].count == 1
    assert found[Kind.JUMP].examples[0].place == "line 151"
    assert Kind.BACK not in found


def test_a_clock_that_was_set_late_begins_where_it_was_set():
    times = [k * NS for k in range(5)] + [1_400_000_000 * NS + k * NS for k in range(200)]
    kept, found = inspected(SERIES, times, still(205))
    assert len(kept) == 200
    assert "had not been set" in found[Kind.JUMP].text


def test_two_recordings_in_one_file_are_refused():
    times = [k * NS for k in range(500, 600)] + [k * NS for k in range(300)]
    with pytest.raises(UserError, match="of 400 rows does not go on"):
        inspected(SERIES, times, still(400), cut=(128, 256))


def test_a_column_that_cannot_be_what_it_is_named_is_refused():
    values = still(200)
    values[60:, 4] = 44_04.14
    _, found = inspected(SERIES, [k * 10_000_000 for k in range(200)], values)
    assert Kind.IMPLAUSIBLE not in found
    values[60:, 4] = 44_041.4
    with pytest.raises(
        UserError, match=r"what 140 of 200 rows tell cannot be .*force_y_mps2.*line 61: 44041.4"
    ):
        inspected(SERIES, [k * 10_000_000 for k in range(200)], values)


def test_values_that_are_none_and_that_cannot_be_are_left_out():
    values = still(200)
    values[20, 1] = math.nan
    values[21, 4] = math.inf
    values[22, 3] = 1e30
    values[23, 6] = math.nan  # the temperature may be missing
    kept, found = inspected(SERIES, [k * 10_000_000 for k in range(200)], values)
    assert len(kept) == 197
    assert found[Kind.NOT_FINITE].count + found[Kind.IMPLAUSIBLE].count <= 3
    assert found[Kind.IMPLAUSIBLE].examples[0].value == "1e+30"


@given(st.integers(0, 700), st.integers(90, 600), st.lists(st.integers(1, 1999), max_size=4, unique=True))
def test_a_channel_that_stands_still_is_told_with_its_length(begin, length, cuts):
    values = still(2000)
    values[begin : begin + length, 2] = 0.125
    _, found = inspected(SERIES, [k * 10_000_000 for k in range(2000)], values, cut=cuts)
    if length > 202:
        (case,) = found[Kind.STUCK].examples
        assert case.place == f"line {begin + 1}"
        assert case.value == f"0.125 for {(length - 1) / 100:.6g} s, {length:,} rows"
        assert found[Kind.STUCK].channel == "/imu/imu rate_z_dps"
    elif length < 200:
        assert Kind.STUCK not in found


def units(gyro="rad/s", accel="m/s2", stated=False):
    return {"gyro": Unit("gyro", gyro, stated), "accel": Unit("accel", accel, stated)}


def checked(rate_dps, force, named, stated=False):
    """Findings of samples that are so and so, named in some units."""
    series = samples("imu", "x.csv", in_line, units(*named, stated))
    table = still(500)
    factors = [series.units[name].factor for name in ("gyro", "accel")]
    table[:, :3] = np.array(rate_dps) * factors[0]
    table[:, 3:6] = np.array(force) * factors[1]
    findings = Findings()
    check = InertialUnits(series, findings)
    check.take(rows_of(series, [k * 10_000_000 for k in range(500)], table))
    check.finish()
    return {finding.kind for finding in findings.all}


@pytest.mark.parametrize(
    ("rate", "force", "named", "better"),
    [
        ((0, 0, 63.2), (0, 0, -9.8), ("rad/s", "m/s2"), "gyro=deg/s"),
        ((0, 0, 0.1), (0, 0, -1.0), ("rad/s", "m/s2"), "accel=g"),
        ((0, 0, 0.1), (0, 0, -9.8), ("rad/s", "g"), "accel=m/s2"),
        ((0, 0, 0.1), (0, 0, -1000.0), ("rad/s", "m/s2"), "accel=mg"),
        ((0, 0, 0.1), (0, 0, -1000.0), ("rad/s", "g"), "accel=mg"),
    ],
)
def test_units_that_cannot_be_are_refused_with_the_right_one(rate, force, named, better):
    with pytest.raises(UnitRefusedError, match=f"--unit {better} "):
        checked(rate, force, named)
    assert Kind.DOUBTFUL_UNIT in checked(rate, force, named, stated=True)


@pytest.mark.parametrize(
    ("rate", "force", "named"),
    [
        ((0, 0, 49.0), (3.0, 0, -9.8), ("rad/s", "m/s2")),
        ((0, 0, 1990.0), (0, 0, -1.0), ("deg/s", "g")),
        ((0, 0, 1.0), (0, 0, -1000.0), ("deg/s", "mg")),
    ],
)
def test_units_that_can_be_are_believed(rate, force, named):
    assert checked(rate, force, named) == set()


def test_forces_without_gravity_are_doubted():
    assert checked((0, 0, 0.1), (0.3, 0.1, 0.2), ("rad/s", "m/s2")) == {Kind.DOUBTFUL_UNIT}


def motion(position="deg", height="m", velocity="m/s", scale=(1.0, 1.0, 1.0), up=1.0):
    """Check a drive up a winding hill whose numbers are `scale` times what the names say."""
    named = {"position": Unit("position", position), "height": Unit("height", height)}
    named["velocity"] = Unit("velocity", velocity)
    series = epochs("x.csv", in_line, named)
    t = np.arange(200.0)
    v = np.column_stack((10 * np.cos(t / 20), 10 * np.sin(t / 20), -np.sin(t / 15)))
    metres = np.cumsum(v, axis=0)
    table = np.full((200, len(series.table.columns) - 1), np.nan)
    table[:, 0] = 1
    table[:, 1] = (47.0 + metres[:, 0] / 111_195.0) * scale[0]
    table[:, 2] = (8.0 + metres[:, 1] / (111_195.0 * math.cos(math.radians(47.0)))) * scale[0]
    table[:, 3] = (480.0 - metres[:, 2]) * scale[1]
    table[:, 4:7] = v * scale[2] * np.array([1, 1, up])
    findings = Findings()
    check = MotionUnits(series, findings)
    for begin in range(0, 200, 64):
        part = slice(begin, begin + 64)
        check.take(rows_of(series, (t[part] * NS).astype(np.int64), table[part], begin + 1))
    check.finish()
    return {finding.kind for finding in findings.all}


def test_positions_that_move_as_told_are_believed():
    assert motion() == set()


@pytest.mark.parametrize(
    ("scale", "better"),
    [
        ((math.pi / 180, 1, 1), "position=rad"),
        ((1, 1 / 0.3048, 1), "height=ft"),
        ((1, 1, 3.6), "velocity=km/h"),
        ((1, 1, 3600 / 1852), "velocity=kn"),
    ],
)
def test_positions_that_move_in_another_unit_are_refused(scale, better):
    with pytest.raises(UnitRefusedError, match=f"--unit {better} "):
        motion(scale=scale)


def test_a_vertical_velocity_upwards_is_doubted():
    assert motion(up=-1.0) == {Kind.DOUBTFUL_UNIT}
