"""Differences between records of two arithmetics, beside other libraries and plain sums."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from firmware.nav.attitude import layout as at
from host.compare.difference import QUANTITIES, Difference, differences
from host.sim.earth import geodetic_to_ecef

ANGLE = st.floats(-1.5, 1.5)
ATTITUDE, POSITION, YAW = (QUANTITIES.index(name) for name in ("attitude", "position", "yaw"))


def records(count: int) -> np.ndarray:
    """At rest at a place, level, facing north."""
    made = np.zeros((count, at.OUT_SIZE), np.int64)
    made[:, at.OUT_QUATERNION] = 10**9
    made[:, at.OUT_LATITUDE] = round(40.85e9)
    made[:, at.OUT_LONGITUDE] = round(111.7e9)
    made[:, at.OUT_HEIGHT] = round(1065e6)
    return made


def with_attitude(rotation: Rotation) -> np.ndarray:
    made = records(1)
    x, y, z, w = rotation.as_quat()
    made[0, at.OUT_QUATERNION : at.OUT_QUATERNION + 4] = np.round(np.array((w, x, y, z)) * 1e9)
    return made


@given(ANGLE, ANGLE, ANGLE, ANGLE, ANGLE, ANGLE)
def test_attitude_is_the_rotation_between_both(
    a: float, b: float, c: float, d: float, e: float, f: float
) -> None:
    one, other = Rotation.from_euler("ZYX", (a, b, c)), Rotation.from_euler("ZYX", (d, e, f))
    found = differences(with_attitude(one), with_attitude(other))[0, ATTITUDE]
    assert found == pytest.approx(np.degrees((one.inv() * other).magnitude()), abs=4e-7)


def test_the_sign_of_a_quaternion_means_nothing() -> None:
    one, other = records(1), records(1)
    other[:, at.OUT_QUATERNION] = -(10**9)
    assert differences(one, other)[0, ATTITUDE] == 0.0


def test_equal_records_differ_by_nothing_whatever_their_rounding() -> None:
    one = with_attitude(Rotation.from_euler("ZYX", (0.3, -1.2, 2.0)))
    assert not differences(one, one.copy()).any()


@given(st.floats(-1e-5, 1e-5), st.floats(-1e-5, 1e-5))
def test_position_is_the_distance_on_the_ellipsoid(north_deg: float, east_deg: float) -> None:
    one, other = records(1), records(1)
    one[0, at.OUT_LATITUDE] += round(north_deg * 1e9)
    one[0, at.OUT_LONGITUDE] += round(east_deg * 1e9)
    places = [
        geodetic_to_ecef(*(np.array([v]) for v in (np.radians(r[0, at.OUT_LATITUDE] * 1e-9),
                                                   np.radians(r[0, at.OUT_LONGITUDE] * 1e-9), 1065.0)))
        for r in (one, other)
    ]  # fmt: skip
    expected = float(np.linalg.norm(places[0] - places[1]))
    assert differences(one, other)[0, POSITION] == pytest.approx(expected, rel=1e-4, abs=2e-6)


def test_longitude_and_yaw_have_no_seam() -> None:
    one, other = records(1), records(1)
    one[0, at.OUT_LONGITUDE], other[0, at.OUT_LONGITUDE] = 180 * 10**9 - 5, -180 * 10**9 + 5
    one[0, at.OUT_YAW], other[0, at.OUT_YAW] = 5, round(2 * np.pi * 1e9) - 5
    found = differences(one, other)[0]
    assert found[POSITION] == pytest.approx(
        10e-9 * np.pi / 180 * 6.38e6 * np.cos(np.radians(40.85)), rel=0.01
    )
    assert found[YAW] == pytest.approx(np.degrees(10e-9), rel=0.05)


@settings(max_examples=20)
@given(st.integers(1, 400), st.integers(0, 2**32 - 1))
def test_sums_do_not_depend_on_how_the_stream_is_cut(cut: int, seed: int) -> None:
    generator = np.random.default_rng(seed)
    times = 2.0 + 0.008 * np.arange(600)
    one, other = records(600), records(600)
    one[:, at.OUT_YAW] = generator.integers(-1000, 1000, 600)
    one[:100, at.OUT_YAW] = 0
    whole, pieces = Difference("fixed", "float64"), Difference("fixed", "float64")
    whole.add(times, one, other)
    for part in (slice(0, cut), slice(cut, 600)):
        pieces.add(times[part], one[part], other[part])
    whole.finish()
    pieces.finish()
    off = np.degrees(np.abs(one[:, at.OUT_YAW]) * 1e-9)
    for found in (whole, pieces):
        assert found.rms["yaw"] == pytest.approx(np.sqrt(np.mean(off**2)))
        assert found.largest[YAW] == off.max()
        assert found.largest_at_s[YAW] == times[np.argmax(off)]
        assert found.first["yaw"].t_s == times[np.flatnonzero(off)[0]]
        assert "velocity" not in found.first
        states = {round(state.since_s, 3): state for state in found.growth}
        assert sorted(states) == [1.0, 3.0, 4.792]
        before = off[times < times[0] + 3.0]
        assert states[3.0].rms[YAW] == pytest.approx(np.sqrt(np.mean(before**2)))
        assert states[3.0].now[YAW] == before[-1]
