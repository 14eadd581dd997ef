"""Sample clock, turn-on, rates, formats, offsets, self-test, sleep: against closed forms of the sheet."""

from __future__ import annotations

from fractions import Fraction
from struct import unpack
from typing import Any

import numpy as np
import pytest
from adxl345_rig import MS, SECOND, US, BenchWorld, G, Rig, rising
from hypothesis import given, settings
from hypothesis import strategies as some

from boards.chips.adxl345 import Adxl345
from hal.emulated.virtual_time import VirtualTime

RATES = {code: Fraction(3200, 2 ** (15 - code)) for code in range(16)}
"""Hz; the sheet prints 0.10, 0.20, 0.39, 0.78, 1.56, 3.13, 6.25 … rounded."""
SHEET_RATES = (0.10, 0.20, 0.39, 0.78, 1.56, 3.13, 6.25, 12.5, 25, 50, 100, 200, 400, 800, 1600, 3200)
TURN_ON_NS = 1_100_000
DATA_READY = 0x80


def exact_instant(start_ns: int, n: int, rate: Fraction, ppm: float = 0.0) -> int:
    real_rate = rate * (1 + Fraction(round(ppm * 1000), 1_000_000_000))
    return start_ns + int(n * SECOND / real_rate)


def test_rates_are_those_of_the_sheet() -> None:
    for code, printed in enumerate(SHEET_RATES):
        assert abs(float(RATES[code]) - printed) <= 0.0055


# -- the sample clock ------------------------------------------------------------------------------


@pytest.mark.parametrize("code", range(16))
@pytest.mark.parametrize("ppm", [0.0, 12_345.678, -3_000.0])
def test_every_sample_comes_at_its_exact_instant(code: int, ppm: float) -> None:
    rig = Rig(listen="INT1", clock_error_ppm=ppm, byte_ns=1600)
    rig.write(0x2E, DATA_READY)
    origin = rig.measure(code) + TURN_ON_NS
    times = [exact_instant(origin, n, RATES[code], ppm) for n in range(1, 6)]
    for k, when in enumerate(times):
        rig.until(when - 1)
        assert len(rising(rig.edges["INT1"])) == k
        rig.until(when)
        assert rising(rig.edges["INT1"])[-1] == when
        rig.read(0x32, 6)
        assert not rig.nets["INT1"].level


def test_turn_on_times_of_the_sheet() -> None:
    for code, milliseconds in ((0xA, 11.1), (0xF, 1.4)):
        rig = Rig(lambda t: {"fz": G})
        start = rig.measure(code)
        rig.until(start + round(milliseconds * MS) - 50 * US)
        assert rig.byte(0x30) & DATA_READY == 0
        rig.until(start + round(milliseconds * MS) + 50 * US)
        assert rig.byte(0x30) & DATA_READY


def test_reading_between_two_samples_shows_the_last_one() -> None:
    rig = Rig(lambda t: {"fx": G * t})
    origin = rig.measure() + TURN_ON_NS
    for n in (1, 2, 30, 31, 500, 1_000):
        for offset in (0, 3 * MS, 9 * MS):
            rig.until(origin + n * 10 * MS + offset)
            sampled_s = (origin + n * 10 * MS) * 1e-9
            assert rig.xyz()[0] == round(256 * sampled_s)


def test_reading_after_hours_without_looking() -> None:
    rig = Rig(lambda t: {"fx": G * (t % 8.0) / 8.0})
    origin = rig.measure() + TURN_ON_NS
    rig.until(origin + 7200 * SECOND + 5 * MS)
    sampled_s = (origin + 7200 * SECOND) * 1e-9
    assert rig.xyz()[0] == round(256 * (sampled_s % 8.0) / 8.0)
    assert sum(call[2] for call in rig.world.calls) < 1000
    assert rig.byte(0x30) & 0x81 == 0
    rig.wait(30 * MS)
    assert rig.byte(0x30) & 0x81 == 0x81


@given(some.lists(some.integers(0, 400_000_000), min_size=1, max_size=30))
@settings(max_examples=40, deadline=None)
def test_common_read_equals_single_registers(gaps: list[int]) -> None:
    """The short way for the six bytes and the general way show the same sample and flags."""

    def motion(t: Any) -> dict[str, Any]:
        return {"fx": G * np.sin(7.0 * t), "fy": 0.5 * G * np.cos(3.0 * t), "fz": G}

    rigs = [Rig(motion, clock_error_ppm=777.0) for _ in range(2)]
    for rig in rigs:
        rig.measure()
    common, general = rigs
    for gap in gaps:
        now = common.time.now + 1_000 + gap
        for rig in rigs:
            rig.until(now)
        a = common.chip.transaction(b"\xf2" + bytes(6), now, now + 35 * US)
        b = general.chip.transaction(b"\xf1" + bytes(7), now, now + 40 * US)
        assert a[1:] == b[2:]
        if gap % 3 == 0:
            for rig in rigs:
                rig.until(now + 41 * US)
            assert common.byte(0x30) == general.byte(0x30)
    assert common.byte(0x30) == general.byte(0x30)


def test_a_new_rate_goes_on_on_the_same_clock() -> None:
    rig = Rig(listen="INT1", clock_error_ppm=500.0)
    rig.write(0x2E, DATA_READY)
    origin = rig.measure() + TURN_ON_NS
    rig.until(exact_instant(origin, 3, RATES[0xA], 500.0) + 1 * MS)
    rig.xyz()
    rig.write(0x2C, 0x0C)
    rig.until(exact_instant(origin, 13, RATES[0xC], 500.0))
    assert rising(rig.edges["INT1"])[-1] == exact_instant(origin, 13, RATES[0xC], 500.0)


def test_noise_bandwidth_follows_the_rate_down_to_100_hz() -> None:
    for code, low_power, bandwidth in (
        (0xF, 0, 3200.0),
        (0xC, 0, 400.0),
        (0xA, 0, 100.0),
        (0x7, 0, 100.0),
        (0xC, 0x10, 570.0),
        (0x7, 0x10, 570.0),
    ):
        rig = Rig()
        rig.measure(code | low_power)
        rig.wait(200 * MS)
        rig.xyz()
        assert {call[3] for call in rig.world.calls} == {bandwidth}


def test_noise_of_the_sheet_comes_out_at_every_rate() -> None:
    """290 µg/√Hz of the world: 0.75 counts up to 100 Hz, √2 more for each doubling, 1.8 in low power."""

    class Noisy(BenchWorld):
        def sample(self, times_ns: Any, bandwidth_hz: float) -> Any:
            values = super().sample(times_ns, bandwidth_hz)
            noise = np.random.default_rng(len(self.calls)).normal(size=len(times_ns))
            values[:, 0] += 290e-6 * G * np.sqrt(bandwidth_hz) * noise
            return values

    for rate, undecimated, wanted in (
        (0x0A, False, 0.75), (0x0A, True, 0.75), (0x08, True, 0.75), (0x0C, False, 1.5), (0x0C, True, 1.5),
        (0x1A, False, 1.8),
    ):  # fmt: skip
        time = VirtualTime()
        chip = Adxl345(time, Noisy())
        setup = [(0x38, 0x80), (0x31, 0x0B), (0x2C, rate), (0x2D, 0x08)]
        if undecimated:  # tap detection never fires, but looks at every tick
            setup[:0] = [(0x1D, 0xFF), (0x21, 0x10), (0x2A, 0x07), (0x2E, 0x40)]
        for register, value in setup:
            chip.transaction(bytes((register, value)), 0, 10_000)
        counts: list[int] = []
        for k in range(1, 80):
            now = k * 100 * MS
            while chip.transaction(b"\xb9\x00", now, now + 10 * US)[1] & 0x3F:
                counts.append(unpack("<h", chip.transaction(b"\xf2" + bytes(6), now, now + 35 * US)[1:3])[0])
                now += 50 * US
        variance = np.var(counts) - 1 / 12  # of rounding
        assert len(counts) > 150
        assert np.sqrt(variance) == pytest.approx(wanted, rel=0.15)


# -- formats ---------------------------------------------------------------------------------------


def expected_word(g: float, data_format: int, rate: int) -> int:
    """The sheet's table of section 3, written down once more."""
    full, left, code = data_format & 0x08, data_format & 0x04, data_format & 0x03
    bits = {0: 10, 1: 11, 2: 12, 3: 13}[code] if full else 10
    per_g = 256 if full else {0: 256, 1: 128, 2: 64, 3: 32}[code]
    count = max(-(2 ** (bits - 1)), min(2 ** (bits - 1) - 1, round(g * per_g)))
    if rate in (0xE, 0xF) and (full or code == 0):
        count -= count % 2
    return count * 2 ** (16 - bits) if left else count


@pytest.mark.parametrize("data_format", range(16))
@pytest.mark.parametrize("rate", [0xA, 0xE, 0xF])
def test_data_format(data_format: int, rate: int) -> None:
    levels = (0.0, 0.61, -0.613, 1.37, -1.999, 2.4, 3.99, -4.7, 7.21, -9.3, 15.9, -16.4, 30.0, -30.0)
    for first in range(len(levels) - 2):
        x, y, z = levels[first : first + 3]
        rig = Rig(lambda t, x=x, y=y, z=z: {"fx": x * G, "fy": y * G, "fz": z * G})  # type: ignore[misc]
        rig.byte_ns = 2 * US
        rig.measure(rate, data_format)
        rig.wait(15 * MS)
        assert rig.xyz() == tuple(expected_word(level, data_format, rate) for level in (x, y, z))


@pytest.mark.parametrize(("data_format", "per_g"), [(0x0B, 256), (0x00, 256), (0x01, 128), (0x03, 32)])
def test_offsets_are_independent_of_the_range(data_format: int, per_g: int) -> None:
    rig = Rig(lambda t: {"fz": G})
    rig.write(0x1E, 64, 0x100 - 32, 0xFF)
    rig.measure(0xA, data_format)
    rig.wait(15 * MS)
    assert rig.xyz() == (per_g, -per_g // 2, round(per_g * (1 - 1 / 64)))


def test_settings_act_from_the_next_sample_on() -> None:
    rig = Rig(lambda t: {"fz": G})
    rig.measure()
    rig.wait(12 * MS)
    assert rig.xyz() == (0, 0, 256)
    rig.write(0x1E, 64)
    assert rig.xyz() == (0, 0, 256)
    rig.wait(10 * MS)
    assert rig.xyz() == (256, 0, 256)
    rig.write(0x31, 0x03)
    rig.wait(10 * MS)
    assert rig.xyz() == (32, 0, 32)


def test_standby_keeps_the_last_sample() -> None:
    rig = Rig(lambda t: {"fx": G * t})
    rig.measure()
    rig.wait(105 * MS)
    last = rig.xyz()
    rig.write(0x2D, 0x00)
    rig.wait(1 * SECOND)
    assert last[0] > 20
    assert rig.xyz() == last
    assert rig.byte(0x00) == 0xE5
    calls = len(rig.world.calls)
    rig.wait(1 * SECOND)
    assert len(rig.world.calls) == calls


def test_starting_again_waits_for_the_turn_on_time() -> None:
    rig = Rig(lambda t: {"fx": G * t}, listen="INT1")
    rig.write(0x2E, DATA_READY)
    rig.measure()
    rig.wait(105 * MS)
    rig.write(0x2D, 0x00)
    rig.xyz()
    rig.wait(95 * MS)
    start = rig.measure()
    rig.until(start + TURN_ON_NS + 10 * MS - 1)
    assert not rig.nets["INT1"].level
    rig.wait(1)
    assert rig.nets["INT1"].level


# -- self-test and supply --------------------------------------------------------------------------

LIMITS = {2.0: (0.64, 0.80), 2.5: (1.0, 1.0), 3.3: (1.77, 1.47), 3.6: (2.11, 1.69)}


@pytest.mark.parametrize("supply_v", LIMITS)
def test_self_test_deflects_within_the_limits(supply_v: float) -> None:
    rig = Rig(lambda t: {"fz": G}, supply_v=supply_v)
    rig.measure()
    rig.wait(100 * MS)
    before = np.array(rig.xyz())
    rig.write(0x31, 0x8B)
    rig.wait(60 * MS)
    change = np.array(rig.xyz()) - before
    xy, z = LIMITS[supply_v]
    assert 50 * xy <= change[0] <= 540 * xy
    assert -540 * xy <= change[1] <= -50 * xy
    assert 75 * z <= change[2] <= 875 * z
    rig.write(0x31, 0x0B)
    rig.wait(60 * MS)
    assert tuple(rig.xyz()) == tuple(before)


def test_self_test_settles_in_four_samples() -> None:
    rig = Rig(lambda t: {})
    rig.measure()
    rig.wait(95 * MS)
    rig.write(0x31, 0x8B)
    steps = []
    for _ in range(6):
        rig.wait(10 * MS)
        steps.append(rig.xyz()[0])
    assert steps[0] < steps[1] < steps[2] < steps[3]
    assert steps[3] == steps[4] == steps[5]


def test_sensitivity_and_offset_at_3_3_volts() -> None:
    rig = Rig(lambda t: {"fx": 4 * G, "fz": 4 * G}, supply_v=3.3)
    rig.measure()
    rig.wait(20 * MS)
    x, y, z = rig.xyz()
    assert abs(x - (4 * 265 + 0.025 * 256)) <= 0.6
    assert abs(y - 0.025 * 256) <= 0.6
    assert abs(z - (4 * 256 - 0.020 * 256)) <= 0.6


# -- sleep -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(("code", "rate_hz"), [(0, 8), (1, 4), (2, 2), (3, 1)])
def test_sleep_samples_at_the_wake_up_rate(code: int, rate_hz: int) -> None:
    rig = Rig(lambda t: {"fx": 0.1 * G * t}, clock_error_ppm=2000.0, listen="INT1")
    rig.write(0x2E, DATA_READY)
    rig.measure()
    rig.wait(100 * MS)
    rig.xyz()
    asleep = rig.time.now + 2 * rig.byte_ns
    rig.write(0x2D, 0x0C | code)
    edges = len(rig.edges["INT1"])
    for n in range(1, 5):
        when = exact_instant(asleep, n, Fraction(rate_hz), 2000.0)
        rig.until(when - 100 * US)
        early = rig.xyz()[0]
        rig.until(when)
        assert rig.xyz()[0] == round(25.6 * when * 1e-9)
        assert early < rig.xyz()[0]
    assert len(rig.edges["INT1"]) == edges
    assert rig.byte(0x30) & DATA_READY == 0


def test_waking_takes_the_turn_on_time() -> None:
    rig = Rig(lambda t: {"fz": G}, listen="INT1")
    rig.write(0x2E, DATA_READY)
    rig.measure(power=0x0C)
    rig.wait(1 * SECOND)
    assert rising(rig.edges["INT1"]) == []
    awake = rig.time.now + 2 * rig.byte_ns
    rig.write(0x2D, 0x08)
    rig.wait(50 * MS)
    assert rising(rig.edges["INT1"]) == [awake + TURN_ON_NS + 10 * MS]


def test_asleep_bit_is_for_auto_sleep_only() -> None:
    rig = Rig()
    rig.measure(power=0x0C)
    rig.wait(1 * SECOND)
    assert rig.byte(0x2B) == 0x00
