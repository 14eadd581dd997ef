"""The fixed-point loop against the same loop in float64, its saturation, and its table of formats."""

import re
from pathlib import Path

import numpy as np
import pytest
from attitude_rig import (
    DEG,
    FLIGHT_BEGIN,
    HEIGHT,
    LATITUDE,
    LONGITUDE,
    Ride,
    angle_between_deg,
    at_rest,
    bursts,
    flight,
)

from firmware.nav.attitude import flags as fl
from firmware.nav.attitude import layout as at
from firmware.nav.attitude.config import AttitudeConfig, quaternion
from firmware.nav.attitude.fixed import layout as fixed
from firmware.nav.attitude.flags import METHOD_NAMES

PAGE = Path(__file__).resolve().parents[2] / "docs" / "fixed-point.md"


def config(**settings):
    place = {"latitude": LATITUDE, "longitude": LONGITUDE, "height": HEIGHT}
    return AttitudeConfig(**(place | {"attitude": FLIGHT_BEGIN} | settings))


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def test_ten_minutes_of_flight_as_in_float64():
    """Wanted is 0.01° RMS; a quarter of a unit of Q30 an iteration, at random, would be 1e-5°."""
    words = bursts(flight(600.0, noise=True))
    ours, reference = (Ride(profile, config()).drive_words(words) for profile in ("fixed", "float64"))
    apart = angle_between_deg(np.array(ours.quaternions), np.array(reference.quaternions))
    assert len(apart) == 600
    assert rms(apart) < 5e-5
    speed = (np.array(ours.records) - np.array(reference.records))[:, at.OUT_VELOCITY : at.OUT_VELOCITY + 3]
    assert np.abs(speed).max() * 1e-6 < 0.02


@pytest.mark.parametrize("method", METHOD_NAMES)
def test_every_update_is_as_in_float64(method):
    words = bursts(flight(60.0, noise=True))
    ours, reference = (
        Ride(profile, config(method=method)).drive_words(words) for profile in ("fixed", "float64")
    )
    apart = angle_between_deg(np.array(ours.quaternions), np.array(reference.quaternions))
    assert rms(apart) < 1e-3


@pytest.mark.parametrize("method", [name for name in METHOD_NAMES if name != "euler_angles"])
@pytest.mark.parametrize("period", [0.0005, 0.02])
def test_at_the_ends_of_the_formats_as_in_float64(method, period):
    """15.5 rad/s and 500 m/s² on every axis at once, at the shortest and the longest period."""
    rng = np.random.Generator(np.random.PCG64(2))
    t = 0.5 * period * np.arange(801)
    rates = 15.5 * np.sin(np.outer(t, (1.1, 2.3, 2.9)) + np.array([1.5, 1.0, 2.0]))
    samples = np.column_stack((rates, rng.uniform(-500.0, 500.0, (801, 3)), np.zeros((801, 3))))
    ours, reference = (
        Ride(profile, config(method=method, period=period)).drive(samples) for profile in ("fixed", "float64")
    )
    assert angle_between_deg(ours.quaternion(), reference.quaternion()) < 5e-5
    speed = (ours.record() - reference.record())[at.OUT_VELOCITY : at.OUT_VELOCITY + 3]
    assert np.abs(speed).max() * 1e-6 < 2e-4
    assert not ours.i[at.SATURATIONS : at.SATURATIONS + 8].any()


def test_rate_far_below_a_unit_an_iteration_still_turns():
    """0.002 °/h in each gyro above the Earth's: 0.08 units of Q30 an iteration."""
    rate = 0.02 * DEG / 3600.0
    samples = at_rest((0.0, 0.0, 0.0), 75_001)
    samples[:, 0] += rate
    ours, reference = (
        Ride(profile, config(attitude=(0.0, 0.0, 0.0), longitude=0.0)).drive(samples)
        for profile in ("fixed", "float64")
    )
    turned = angle_between_deg(reference.quaternion(), np.array(quaternion((0.0, 0.0, 0.0))))
    assert turned == pytest.approx(np.degrees(rate * 300.0), rel=0.1)
    assert angle_between_deg(ours.quaternion(), reference.quaternion()) < 5e-4


KINDS = [
    ("rate", slice(0, 3), 15.9, "SATURATED_RATE"),
    ("force", slice(3, 6), 511.0, "SATURATED_FORCE"),
    ("field", slice(6, 9), 9.7e-4, "SATURATED_FIELD"),
]


@pytest.mark.parametrize(("name", "places", "value", "kind"), KINDS)
def test_saturation_is_counted_by_kind(name, places, value, kind):
    """Three axes at the end of their format, mounted askew, are beyond it on one axis."""
    askew = (0.5774, 0.5774, 0.5774, -0.7071, 0.7071, 0.0, -0.4082, -0.4082, 0.8165)
    matrix = np.array(askew).reshape(3, 3)
    first, _, third = np.linalg.svd(matrix)
    one = Ride("fixed", config(C_b_s=tuple((first @ third).ravel())))
    row = np.zeros((1, 9))
    row[0, places] = value
    one.drive(row)
    counted = one.i[at.SATURATIONS : at.SATURATIONS + 8]
    assert counted[getattr(fl, kind)] == 1
    assert counted.sum() == 1
    assert one.record()[at.OUT_SATURATIONS] == 1


def test_speed_beyond_its_format_saturates_and_is_counted():
    """40 m/s² for half a minute is 1200 m/s; the format ends at 1024."""
    row = np.array([0.0, 0.0, 0.0, 40.0, 0.0, -9.8, 0.0, 0.0, 0.0])
    one = Ride("fixed", config(attitude=(0.0, 0.0, 0.0))).drive(np.tile(row, (7501, 1)))
    assert one.i[at.SATURATIONS + fl.SATURATED_VELOCITY] > 0
    assert one.record()[at.OUT_VELOCITY] == pytest.approx(1024e6, rel=1e-6)


@pytest.mark.parametrize("method", METHOD_NAMES)
def test_garbage_for_minutes_leaves_a_rotation_behind(method):
    """Words at random: whatever comes, the quaternion keeps its length and angles their ranges."""
    rng = np.random.Generator(np.random.PCG64(5))
    words = rng.integers(0, 0x10000, (20_001, 14))
    words[:, 0], words[:, 10] = 0x8814, 0xB0D4
    one = Ride("fixed", config(method=method)).drive_words(words)
    q = one.s[:4] * 2.0**-30
    assert np.linalg.norm(q) == pytest.approx(1.0, abs=1e-7)
    yaw, pitch, roll = one.angles_deg
    assert 0.0 <= yaw < 360.0
    assert -90.0 <= pitch <= 90.0
    assert -180.0 <= roll <= 180.0


@pytest.mark.parametrize("latitude_deg", [-90.0, -89.999, -30.0, 0.0, 60.0, 89.999, 90.0])
@pytest.mark.parametrize("height", [-9_000.0, 0.0, 99_000.0])
def test_earth_as_in_float64(latitude_deg, height):
    settings = {"latitude": np.clip(latitude_deg * DEG, -np.pi / 2, np.pi / 2), "height": height}
    samples = flight(0.1)
    ours, reference = (Ride(profile, config(**settings)).drive(samples) for profile in ("fixed", "float64"))
    for place, _, bits in fixed.FORMATS:
        if at.EARTH_RATE_N <= place <= at.GRAVITY:
            unit = 2.0**-bits
            # a unit of the cosine in Q30 is what the east-west terms near a pole hang on
            share = 4e-9 + 2.0**-30 * reference.s[at.PER_COS_LATITUDE]
            assert ours.s[place] * unit == pytest.approx(reference.s[place], rel=share, abs=2.0 * unit)


def test_page_names_every_format():
    """The range analysis has a row for each number of the state, with the format that it has."""
    rows = re.findall(r"^\| `(\w+)`.*?\| Q(\d+) \|", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    names = {name: int(bits) for name, bits in rows}
    places = {getattr(fixed, name): bits for name, bits in names.items()}
    assert {place: bits for place, _, bits in fixed.FORMATS} == places
