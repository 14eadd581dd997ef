"""What the loop reads out of a burst, what it notices about it, and how it bridges what is no sample."""

import numpy as np
import pytest
from attitude_rig import DEG, EVERY_PROFILE, Ride, at_rest, bursts

from firmware.nav.attitude import flags as fl
from firmware.nav.attitude import layout as at
from firmware.nav.attitude.config import AttitudeConfig
from firmware.nav.attitude.fixed import layout as fixed

G = 9.80665
SUPPLY, XGYRO, ZGYRO, XACCL, ZACCL, XMAGN, BARO = 0, 1, 3, 4, 6, 7, 10


def good():
    """Words of a part at rest, level: every register new, 5 V, 1000 mbar, a field."""
    words = np.full(14, 0x8000, np.int64)
    words[SUPPLY] = 0x8814
    words[ZACCL] = 0xBED4
    words[XMAGN : XMAGN + 3] = 0x8190, 0x8000, 0x8320
    words[BARO] = 0xB0D4
    return words


def ride(profile, **settings):
    return Ride(profile, AttitudeConfig(attitude=(0.0, 0.0, 0.0), **settings))


def taken(one, words):
    """What was noticed, and the newest ω and f in °/s and g."""
    found = one.loop.take_words(one.s, one.i, words)
    newest = np.r_[0:3] + at.NEWEST
    omega, force = one.s[at.OMEGA + newest].astype(float), one.s[at.FORCE + newest].astype(float)
    if one.loop.profile == "fixed":
        omega, force = omega * 2.0**-fixed.Q_RATE, force * 2.0**-fixed.Q_FORCE
    return found, omega / DEG, force / G


@pytest.mark.parametrize("profile", EVERY_PROFILE)
@pytest.mark.parametrize(
    ("word", "rate"), [(0x1770, 300.0), (0x3FFF, -0.05), (0x2890, -300.0), (0x0000, 0.0), (0x0001, 0.05)]
)
def test_worked_rates_of_the_document(profile, word, rate):
    for ready in (0x8000, 0xC000, 0x0000):
        words = good()
        words[ZGYRO] = ready | word
        found, omega, _ = taken(ride(profile), words)
        assert omega == pytest.approx((0.0, 0.0, rate), abs=2e-5)
        assert bool(found & fl.GYRO_SATURATED) == (abs(rate) >= 300.0)


@pytest.mark.parametrize("profile", EVERY_PROFILE)
@pytest.mark.parametrize(
    ("word", "force"), [(0x1519, 5401 / 300), (0x2AE7, -5401 / 300), (0x012C, 1.0), (0x3ED4, -1.0)]
)
def test_worked_forces_of_the_document(profile, word, force):
    """+18 g is 0x1519 and −18 g 0x2AE7, at 3.333 mg a count."""
    words = good()
    words[XACCL] = 0x8000 | word
    _, _, found = taken(ride(profile), words)
    assert found[0] == pytest.approx(force, abs=1e-5)


@pytest.mark.parametrize("profile", EVERY_PROFILE)
def test_captured_supply_word_is_noticed(profile):
    """0xC7A7: new data, an alarm, 0x7A7 · 2.418 mV = 4.74 V, below 4.75 V."""
    words = good() | 0x4000
    words[SUPPLY] = 0xC7A7
    found, _, force = taken(ride(profile), words)
    assert found == fl.CHIP_ERROR | fl.SUPPLY
    assert force[2] == pytest.approx(-1.0, abs=1e-6)


@pytest.mark.parametrize(
    ("supply_v", "outside"), [(4.70, True), (4.76, False), (5.00, False), (5.24, False), (5.30, True)]
)
def test_supply_limits(supply_v, outside):
    words = good()
    words[SUPPLY] = 0x8000 | round(supply_v / 2.418e-3)
    found, _, _ = taken(ride("fixed"), words)
    assert bool(found & fl.SUPPLY) == outside
    assert not found & fl.BRIDGED


def spoilt(kind):
    words = good()
    if kind == "stale":
        words &= 0x7FFF
    elif kind == "slipped late":
        words = np.roll(words, 1)
    elif kind == "slipped early":
        words = np.roll(words, -1)
    elif kind == "nobody, low":
        words[:] = 0
    elif kind == "nobody, high":
        words[:] = 0xFFFF
    elif kind == "no magnetometer":
        words[XMAGN : XMAGN + 3] = 0x8000
    elif kind == "one bit late":
        bits = "".join(f"{word:016b}" for word in words)
        bits = "0" + bits[:-1]
        words = np.array([int(bits[k : k + 16], 2) for k in range(0, len(bits), 16)], np.int64)
    return words


@pytest.mark.parametrize("profile", ["float32", "fixed"])
@pytest.mark.parametrize(
    ("kind", "noticed"),
    [
        ("stale", fl.STALE),
        ("slipped late", fl.SLIPPED | fl.BRIDGED),
        ("slipped early", fl.SLIPPED | fl.BRIDGED),
        ("one bit late", fl.SLIPPED | fl.BRIDGED),
        ("nobody, low", fl.NO_ANSWER | fl.BRIDGED),
        ("nobody, high", fl.NO_ANSWER | fl.BRIDGED),
        ("no magnetometer", fl.FIELD_IMPLAUSIBLE),
    ],
)
def test_what_is_wrong_is_noticed_counted_and_told_once(profile, kind, noticed):
    one = ride(profile)
    found, _, _ = taken(one, spoilt(kind))
    assert found & noticed == noticed
    assert one.record()[at.OUT_FLAGS] == found
    assert one.record()[at.OUT_FLAGS] == 0
    for bit in range(16):
        assert one.i[at.NOTICES + bit] == found >> bit & 1


@pytest.mark.parametrize("profile", EVERY_PROFILE)
@pytest.mark.parametrize(
    "kind", ["slipped late", "slipped early", "one bit late", "nobody, low", "nobody, high"]
)
def test_bridged_samples_are_as_if_the_one_before_had_come_again(profile, kind):
    turning = good()
    turning[XGYRO : ZGYRO + 1] = 0x8000 | 400, 0x8000 | 100, 0x8000 | 37
    bridged, repeated = ride(profile), ride(profile)
    for k in range(201):
        bad = k % 5 == 3
        bridged.drive_words(np.array([spoilt(kind) if bad else turning]))
        repeated.drive_words(np.array([turning]))
    assert np.array_equal(bridged.s, repeated.s)
    assert bridged.i[at.ITERATIONS] == repeated.i[at.ITERATIONS] == 100


@pytest.mark.parametrize("profile", EVERY_PROFILE)
def test_rates_are_lost_after_half_a_second_and_back_with_the_first_sample(profile):
    one = ride(profile)
    found = [one.loop.bridge(one.s, one.i) for _ in range(126)]
    assert [bool(word & fl.RATES_LOST) for word in found] == [False] * 125 + [True]
    assert taken(one, good())[0] & fl.RATES_LOST == 0


@pytest.mark.parametrize("profile", EVERY_PROFILE)
def test_sample_too_many_is_noticed(profile):
    one = ride(profile)
    found = [one.loop.take_words(one.s, one.i, good()) for _ in range(4)]
    assert [word & fl.OVERRUN for word in found] == [0, 0, 0, fl.OVERRUN]
    assert one.loop.iterate(one.s, one.i) == 1
    assert one.loop.iterate(one.s, one.i) == 0


@pytest.mark.parametrize("profile", EVERY_PROFILE)
@pytest.mark.parametrize("range_dps", [75, 150, 300])
def test_gyro_range_scales_the_counts(profile, range_dps):
    words = good()
    words[XGYRO] = 0x8000 | 1000
    _, omega, _ = taken(ride(profile, gyro_range_dps=range_dps), words)
    assert omega[0] == pytest.approx(50.0 * range_dps / 300.0, abs=2e-5)


@pytest.mark.parametrize("profile", EVERY_PROFILE)
def test_mounting_turns_sensor_axes_into_body_axes(profile):
    """Sensor x is body right, sensor y body front, sensor z body up."""
    words = good()
    words[XGYRO : ZGYRO + 1] = 0x8000 | 200, 0x8000 | 100, 0x8000 | 40
    one = ride(profile, C_b_s=(0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0))
    _, omega, force = taken(one, words)
    assert omega == pytest.approx((5.0, 10.0, -2.0), abs=2e-5)
    assert force == pytest.approx((0.0, 0.0, 1.0), abs=1e-6)


@pytest.mark.parametrize("profile", EVERY_PROFILE)
def test_words_and_rates_are_two_doors_to_the_same_room(profile):
    """Rates that are whole counts give the same state by either door, but for rounding."""
    samples = at_rest((0.3, 0.1, -0.2), 251)
    samples[:, 0:3] = np.array([40, -25, 8]) * 0.05 * DEG
    samples[:, 3:6] = np.array([20, -31, -299]) * G / 300.0
    by_rates, by_words = ride(profile).drive(samples), ride(profile).drive_words(bursts(samples))
    assert by_words.quaternion() == pytest.approx(by_rates.quaternion(), abs=1e-6)
    assert by_words.record()[at.OUT_VELOCITY] == pytest.approx(by_rates.record()[at.OUT_VELOCITY], abs=20)
