"""Motion interrupts on accelerations with known slopes (motion.py's rules; thresholds in mg at 2 g)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from bmi160_rig import MS, G, Rig, rising

from boards.chips.bmi160.motion import no_motion_ticks

OUTPUT = ((0x53, 0x0A), (0x55, 0xFF), (0x56, 0xF0))


def motion_rig(motion: Any, *writes: tuple[int, int]) -> Rig:
    """Accelerometer at 100 Hz; the interrupt on INT1, switched on last, at about 100 ms."""
    rig = Rig(motion, listen="INT1")
    rig.start(gyro=False)
    rig.until(99 * MS)
    for register, value in (*OUTPUT, *writes):
        rig.write(register, value, gap_ns=2_000)
    return rig


def ramp(slope_mg: float, begin: float, end: float, axis: str = "fx") -> Any:
    """A ramp of `slope_mg` per sample at 100 Hz between two times; z holds 1 g."""

    def motion(t: np.ndarray) -> dict[str, Any]:
        ramped = slope_mg * 1e-3 * G * 100.0 * (np.clip(t, begin, end) - begin)
        return {"fz": G + (ramped if axis == "fz" else 0.0), axis: ramped + (G if axis == "fz" else 0.0)}

    return motion


# -- any-motion --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("samples", "first"), [(1, 210), (2, 220), (4, 240)])
def test_any_motion_after_its_number_of_slopes(samples: int, first: int) -> None:
    """Threshold 5 · 3.9 mg = 19.5 mg; 25 mg a sample from 200 ms on: slopes at 210, 220 … ms."""
    rig = motion_rig(ramp(25.0, 0.2, 0.5), (0x5F, samples - 1), (0x60, 5), (0x50, 0x07))
    rig.until(1_000 * MS)
    assert rig.edges["INT1"] == [(first * MS, True), ((500 + 10 * samples) * MS, False)]


@pytest.mark.parametrize(("slope", "fires"), [(19.0, False), (20.0, True)])
def test_any_motion_threshold(slope: float, fires: bool) -> None:
    rig = motion_rig(ramp(slope, 0.2, 0.5), (0x60, 5), (0x50, 0x07))
    rig.until(1_000 * MS)
    assert bool(rig.edges["INT1"]) is fires


@pytest.mark.parametrize(("slope", "fires"), [(1.9, False), (2.1, True)])
def test_threshold_zero_is_half_a_step(slope: float, fires: bool) -> None:
    rig = motion_rig(ramp(slope, 0.2, 0.8), (0x60, 0), (0x50, 0x07))
    rig.until(1_000 * MS)
    assert bool(rig.edges["INT1"]) is fires


def test_any_motion_threshold_scales_with_the_range() -> None:
    rig = motion_rig(ramp(25.0, 0.2, 0.5), (0x41, 0x05), (0x60, 5), (0x50, 0x07))
    rig.until(1_000 * MS)
    assert rig.edges["INT1"] == []


@pytest.mark.parametrize(("axis", "bit"), [("fx", 0x01), ("fy", 0x02), ("fz", 0x04)])
@pytest.mark.parametrize(("slope", "sign"), [(25.0, 0x00), (-25.0, 0x08)])
def test_any_motion_tells_axis_and_sign(axis: str, bit: int, slope: float, sign: int) -> None:
    rig = motion_rig(ramp(slope, 0.2, 0.5, axis), (0x60, 5), (0x50, 0x07))
    rig.until(300 * MS)
    assert rig.read(0x1C, 4) == bytes((0x04, 0x00, bit | sign, 0x00))
    rig.until(600 * MS)
    assert rig.read(0x1C, 4) == bytes(4)


def test_any_motion_of_a_disabled_axis_is_not_seen() -> None:
    rig = motion_rig(ramp(25.0, 0.2, 0.5), (0x60, 5), (0x50, 0x06))
    rig.until(1_000 * MS)
    assert rig.edges["INT1"] == []


def test_any_motion_latched_until_the_status_is_read() -> None:
    rig = motion_rig(ramp(25.0, 0.2, 0.5), (0x60, 5), (0x54, 0x0F), (0x50, 0x07))
    rig.until(1_000 * MS)
    assert rig.edges["INT1"] == [(210 * MS, True)]
    assert rig.read(0x1C, 4) == bytes((0x04, 0x00, 0x01, 0x00))
    assert not rig.nets["INT1"].level
    assert rig.read(0x1C, 4) == bytes(4)


def test_any_motion_is_found_without_a_listener_too() -> None:
    rig = Rig(ramp(25.0, 0.2, 0.5))
    rig.start(gyro=False)
    for write in ((0x60, 5), (0x54, 0x0F), (0x50, 0x07)):
        rig.write(*write, gap_ns=2_000)
    events = rig.time.events_run
    rig.until(5_000 * MS)
    assert rig.time.events_run == events
    assert rig.read(0x1C) == b"\x04"


# -- slow-motion and no-motion -------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("code", "seconds"),
    [(0x00, 1.28), (0x0F, 20.48), (0x10, 25.6), (0x1F, 102.4), (0x20, 112.64), (0x3F, 430.08)],
)
def test_no_motion_durations(code: int, seconds: float) -> None:
    assert no_motion_ticks(code) == round(seconds * 25600)


def test_no_motion_after_quiet_time_and_its_end() -> None:
    """Quiet since 500 ms (last slope); two units of 1.28 s; motion again from 4 s on."""

    def motion(t: np.ndarray) -> dict[str, Any]:
        first, second = ramp(25.0, 0.2, 0.5)(t)["fx"], ramp(25.0, 4.0, 4.1)(t)["fx"]
        return {"fx": first + second, "fz": G}

    rig = motion_rig(motion, (0x5F, 1 << 2), (0x61, 5), (0x62, 0x25), (0x52, 0x07))
    rig.until(4_200 * MS)
    assert rig.edges["INT1"] == [(3_060 * MS, True), (4_010 * MS, False)]


def test_slow_motion_is_any_motion_with_its_own_settings() -> None:
    rig = motion_rig(ramp(25.0, 0.2, 0.5), (0x5F, 2 << 2), (0x61, 5), (0x52, 0x07))
    rig.until(1_000 * MS)
    assert rig.edges["INT1"] == [(230 * MS, True), (530 * MS, False)]
    assert rig.read(0x1D) == b"\x00"


# -- high-g --------------------------------------------------------------------------------------------------


def step(levels: list[tuple[float, float]], axis: str = "fx") -> Any:
    """Piecewise constant acceleration in g: (from time, level)."""

    def motion(t: np.ndarray) -> dict[str, Any]:
        value = np.zeros(len(t))
        for begin, level in levels:
            value = np.where(t >= begin - 1e-9, level, value)
        return {axis: value * G}

    return motion


def test_high_g_after_its_delay_and_with_hysteresis() -> None:
    """Threshold 128 · 7.8 mg = 1 g, hysteresis 2 · 125 mg, delay (7 + 1) · 2.5 ms = 20 ms."""
    motion = step([(0.2, 1.2), (0.4, 0.9), (0.5, 0.7)])
    rig = motion_rig(motion, (0x5E, 128), (0x5C, 0x81), (0x5D, 7), (0x51, 0x07))
    rig.until(1_000 * MS)
    assert rig.edges["INT1"] == [(220 * MS, True), (520 * MS, False)]


def test_high_g_shorter_than_its_delay_is_ignored() -> None:
    rig = motion_rig(step([(0.2, 1.2), (0.22, 0.0)]), (0x5E, 128), (0x5D, 7), (0x51, 0x07))
    rig.until(1_000 * MS)
    assert rig.edges["INT1"] == []


def test_high_g_needs_one_sign() -> None:
    rig = motion_rig(step([(0.2, 1.2), (0.22, -1.2), (0.24, 1.2)]), (0x5E, 128), (0x5D, 11), (0x51, 0x07))
    rig.until(265 * MS)
    assert rig.edges["INT1"] == []
    rig.until(300 * MS)
    assert rising(rig.edges["INT1"]) == [270 * MS]


@pytest.mark.parametrize(("axis", "bit"), [("fx", 0x01), ("fy", 0x02), ("fz", 0x04)])
@pytest.mark.parametrize(("level", "sign"), [(1.2, 0x00), (-1.2, 0x08)])
def test_high_g_tells_axis_and_sign(axis: str, bit: int, level: float, sign: int) -> None:
    rig = motion_rig(step([(0.2, level)], axis), (0x5E, 128), (0x51, 0x07))
    rig.until(300 * MS)
    assert rig.read(0x1C, 4) == bytes((0x00, 0x04, 0x00, bit | sign))


# -- low-g ---------------------------------------------------------------------------------------------------


def test_low_g_in_free_fall() -> None:
    """Defaults: threshold 48 · 7.8 mg = 375 mg, delay (7 + 1) · 2.5 ms, hysteresis 125 mg."""
    motion = step([(0.0, 1.0), (0.2, 0.3), (0.4, 0.45), (0.5, 0.55)], "fz")
    rig = motion_rig(motion, (0x51, 0x08))
    rig.until(1_000 * MS)
    assert rig.edges["INT1"] == [(220 * MS, True), (500 * MS, False)]


def test_low_g_sum_mode_adds_the_axes() -> None:
    """0.25 g on each axis: below 375 mg one by one, above in sum."""
    fall = dict.fromkeys(("fx", "fy", "fz"), 0.25 * G)
    rigs = [motion_rig(lambda t: fall, (0x5C, mode), (0x51, 0x08)) for mode in (0x81, 0x85)]
    for rig in rigs:
        rig.until(500 * MS)
    assert rigs[0].nets["INT1"].level
    assert not rigs[1].nets["INT1"].level


@pytest.mark.parametrize("code", [0x03, 0x05, 0x08, 0x0C])
def test_low_g_threshold_does_not_depend_on_the_range(code: int) -> None:
    motion = step([(0.0, 0.45), (0.3, 0.33)], "fz")
    rig = motion_rig(motion, (0x41, code), (0x51, 0x08))
    rig.until(1_000 * MS)
    assert rising(rig.edges["INT1"]) == [320 * MS]
