"""Sample instants, filter, ranges, corrections: closed forms and plain references."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from adis16407_rig import MS, SECOND, START_UP, G, Rig, instant
from hypothesis import given, settings
from hypothesis import strategies as some


def signed(word: int, bits: int = 14) -> int:
    value = word & ((1 << bits) - 1)
    return value - (1 << bits) if value >> (bits - 1) else value


def rising(rig: Rig, pin: str = "DIO1") -> list[int]:
    return [when for when, level in rig.edges[pin] if level]


def test_samples_come_at_819_2_hz_for_ever() -> None:
    rig = Rig(listen="DIO1", started=False)
    rig.until(START_UP + 3 * SECOND)
    assert rising(rig) == [instant(n) for n in range(2458)]


@pytest.mark.parametrize("code", [0x01, 0x02, 0x07, 0x0F, 0x1F, 0x7F, 0x80, 0x81, 0x85])
@pytest.mark.parametrize("ppm", [0.0, 400.0, -250.0])
def test_periods(code: int, ppm: float) -> None:
    """Time base (0.61035 ms = 10/16384 s, the slow one 31 times that) × (N_S + 1), on a clock that is off."""
    rig = Rig(listen="DIO1", clock_error_ppm=ppm)
    changed = rig.time.now
    rig.edges["DIO1"].clear()
    rig.word(0xBA00 | code)
    base = Fraction(10, 16384) * (31 if code & 0x80 else 1)
    period = base * ((code & 0x7F) + 1) / (1 + Fraction(ppm) / 1_000_000)
    rig.until(changed + int(5 * period * SECOND) + 10 * MS)
    found = [when - changed for when in rising(rig)]
    first, *_ = found
    assert first == pytest.approx(float(period) * SECOND, abs=1)
    assert len(found) >= 5
    assert found == pytest.approx([float(k * period * SECOND) for k in range(1, len(found) + 1)], abs=2.01)


def test_looking_late_gives_the_same_as_looking_always() -> None:
    def motion(t: Any) -> dict[str, Any]:
        return {"wx": 100.0 * np.sin(40.0 * t), "fz": G * np.cos(3.0 * t), "by": 0.3 * np.sin(t)}

    often, seldom = Rig(motion, listen="DIO1"), Rig(motion)
    for k in range(1, 40):
        often.until(START_UP + k * 50 * MS)
        words = often.burst()
        if k % 13 == 0:
            seldom.until(START_UP + k * 50 * MS)
            assert seldom.burst() == words


@pytest.mark.parametrize("n", range(8))
def test_filter_is_two_means(n: int) -> None:
    """A step at sample 400 against the running sums written out."""
    rig = Rig(lambda t: {"wz": 200.0 * (t >= instant(400) * 1e-9 - 1e-9), "bz": 1.0 * (t > 0.5)})
    rig.word(0xBC00 | n)
    rig.word(0xBD04)
    taps = 1 << n
    response = np.cumsum(np.convolve(np.ones(taps), np.ones(taps)) / taps**2)
    for k in (399, 400, 401, 403, 400 + taps - 1, 400 + 2 * taps - 3, 400 + 2 * taps - 2, 400 + 2 * taps):
        if k * 1_220_703 + START_UP < rig.time.now:
            continue
        rig.until(instant(k))
        expected = 0.0 if k < 400 else float(response[min(k - 400, len(response) - 1)])
        assert signed(rig.burst()[3]) == pytest.approx(4000 * expected, abs=0.51)


@pytest.mark.parametrize(("code", "dps"), [(4, 300.0), (2, 150.0), (1, 75.0)])
def test_gyro_ranges(code: int, dps: float) -> None:
    rig = Rig(lambda t: {"wx": 60.0, "wy": -60.0, "wz": 500.0})
    rig.word(0xBD00 | code)
    rig.wait(20 * MS)
    burst = rig.burst()
    counts = round(60.0 / (0.05 * dps / 300.0))
    assert [signed(word) for word in burst[1:4]] == [counts, -counts, 8191]
    assert rig.read(0x40) & 0x0010  # over-range


@settings(max_examples=40, deadline=None)
@given(
    some.floats(-290, 290), some.floats(-17.9, 17.9), some.floats(-2.4, 2.4), some.floats(11, 1199),
    some.floats(-40, 105), some.floats(4.76, 5.24), some.floats(0, 3.3),
)  # fmt: skip
def test_units(
    rate: float, g: float, gauss: float, mbar: float, celsius: float, v: float, adc: float
) -> None:
    felt = {"wy": rate, "fy": g * G, "by": gauss, "pressure": mbar, "temperature": celsius}
    rig = Rig(lambda t: felt, supply_v=v, aux_adc_v=adc)
    burst = rig.burst()
    assert signed(burst[2]) * 0.05 == pytest.approx(rate, abs=0.0251)
    assert signed(burst[5]) / 300.0 == pytest.approx(g, abs=0.00167)
    assert signed(burst[8]) * 0.5e-3 == pytest.approx(gauss, abs=0.251e-3)
    pressure = ((burst[10] & 0x3FFF) << 8 | burst[11] & 0xFF) * 0.0003125
    assert pressure == pytest.approx(mbar, abs=0.00016)
    assert 25.0 + signed(burst[12], 12) * 0.136 == pytest.approx(celsius, abs=0.0681)
    assert (burst[0] & 0xFFF) * 2.418e-3 == pytest.approx(v, abs=1.22e-3)
    assert (burst[13] & 0xFFF) * 0.806e-3 == pytest.approx(adc, abs=0.41e-3)
    assert not any(word & 0x4000 for word in burst)


@settings(max_examples=30, deadline=None)
@given(
    some.integers(-4096, 4095), some.integers(-2048, 2047), some.integers(-8192, 8191), some.integers(0, 4095)
)
def test_corrections(gyro: int, accel: int, hard: int, soft: int) -> None:
    rig = Rig(lambda t: {"wx": 10.0, "fx": 2.0 * G, "bx": 0.4})
    rig.write(0x1E, gyro & 0xFFFF)
    rig.write(0x24, accel & 0xFFFF)
    rig.write(0x2A, hard & 0xFFFF)
    rig.write(0x30, soft)
    rig.wait(5 * MS)
    burst = rig.burst()
    assert signed(burst[1]) == pytest.approx(200 + gyro / 4, abs=0.51)
    assert signed(burst[4]) == 600 + accel
    expected = np.clip(800 * soft / 2048 + hard, -8192, 8191)
    assert signed(burst[7]) == pytest.approx(float(expected), abs=0.51)


def test_corrections_change_no_sample_that_was_taken() -> None:
    rig = Rig()
    rig.until(instant(5) + 10_000)
    rig.write(0x24, 100)
    assert signed(rig.burst()[4]) == 0
    rig.until(instant(6))
    assert signed(rig.burst()[4]) == 100


def test_manual_self_test_deflects_both_ways() -> None:
    rig = Rig()
    still = rig.burst()
    means = []
    for bits in (0x01, 0x02, 0x00):
        rig.word(0xB900 | bits)
        rig.wait(5 * MS)
        means.append([signed(word) for word in rig.burst()[1:7]])
    up, down, none = means
    assert none == [signed(word) for word in still[1:7]]
    assert all(a > b > c for a, b, c in zip(up, none, down, strict=True))


def test_external_clock() -> None:
    rig = Rig(lambda t: {"temperature": 25.0 + 13.6 * t}, listen="DIO1")
    rig.word(0xBA00)
    rig.burst()
    rig.edges["DIO1"].clear()
    rig.wait(50 * MS)
    assert rising(rig) == []
    assert not any(word >> 15 for word in rig.burst())
    edges = []
    for _ in range(30):
        rig.wait(1 * MS)
        edges.append(rig.time.now)
        rig.nets["DIO4"].set(True)
        rig.wait(200_000)
        rig.nets["DIO4"].set(False)
    assert rising(rig) == edges
    word = rig.read(0x1A)
    assert word >> 15 == 1
    assert signed(word, 12) == round(100.0 * edges[-1] * 1e-9)
    assert rig.chip.reports == []
    rig.nets["DIO4"].set(True)
    rig.wait(500_000)
    rig.nets["DIO4"].set(False)
    rig.nets["DIO4"].set(True)
    assert "faster than 1.1 kHz" in str(rig.chip.reports)
    rig.word(0xBA01)
    rig.edges["DIO1"].clear()
    rig.wait(10 * MS)
    assert len(rising(rig)) == 8


def test_nothing_runs_while_nobody_looks() -> None:
    rig = Rig()
    events = rig.time.events_run
    rig.wait(100 * SECOND)
    assert rig.time.events_run == events
    assert len(rig.world.calls) <= 1
