"""Offsets, fast offset compensation, non-volatile memory, self-tests (fact sheet sections 3 and 5)."""

from __future__ import annotations

from math import radians
from typing import Any

import numpy as np
import pytest
from bmi160_rig import MS, G, Rig
from hypothesis import given, settings
from hypothesis import strategies as st

from boards.chips.registers import ReportKind

OFFSETS = 0x71
ENABLES = 0x77
STATUS = 0x1B
FOC_READY = 0x08


def foc(rig: Rig, conf: int) -> None:
    rig.write(0x69, conf, gap_ns=2_000)
    rig.write(0x7E, 0x03, gap_ns=250 * MS)


def tilted(t: Any) -> dict[str, float]:
    """Biases of +40, −20, +10 mg and +1, −2, +0.5 deg/s, z up."""
    return {
        "fx": 0.040 * G, "fy": -0.020 * G, "fz": 1.010 * G,
        "wx": radians(1.0), "wy": radians(-2.0), "wz": radians(0.5),
    }  # fmt: skip


# -- offsets -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("acc_range", "counts_per_g"), [(0x03, 16384), (0x05, 8192), (0x08, 4096), (0x0C, 2048)]
)
@pytest.mark.parametrize(
    ("code", "mg"), [(0x01, 3.90625), (0x40, 250), (0x7F, 496.09375), (0xFF, -3.90625), (0x80, -500)]
)
def test_accelerometer_offset_is_added_in_every_range(
    acc_range: int, counts_per_g: int, code: int, mg: float
) -> None:
    rig = Rig(motion=lambda t: {"fy": 0.25 * G})
    rig.start(gyro=False)
    rig.write(0x41, acc_range)
    rig.write(OFFSETS + 1, code)
    rig.write(ENABLES, 0x40)
    rig.wait(20 * MS)
    assert rig.sample()[3:] == (0, round((0.25 + mg / 1000) * counts_per_g), 0)


@pytest.mark.parametrize("gyr_range", [0, 2, 4])
@pytest.mark.parametrize(
    ("code", "degrees"),
    [(0x001, 31.25 / 512), (0x1FF, 511 * 31.25 / 512), (0x3FF, -31.25 / 512), (0x200, -31.25)],
)
def test_gyroscope_offset_is_ten_bits(gyr_range: int, code: int, degrees: float) -> None:
    rig = Rig(motion=lambda t: {"wz": radians(40.0)})
    rig.start(accel=False)
    rig.write(0x43, gyr_range)
    rig.write(OFFSETS + 5, code & 0xFF)
    rig.write(ENABLES, 0x80 | (code >> 8) << 4)
    rig.wait(20 * MS)
    assert rig.sample()[:3] == (0, 0, round((40.0 + degrees) * 16.4 * 2**gyr_range))


@pytest.mark.parametrize(
    ("enables", "accel", "gyro"), [(0x00, 0, 0), (0x40, 64, 0), (0x80, 0, 1), (0xC0, 64, 1)]
)
def test_offsets_act_only_when_enabled(enables: int, accel: int, gyro: int) -> None:
    rig = Rig(motion=lambda t: {})
    rig.start()
    rig.write(OFFSETS, 1, gap_ns=2_000)
    rig.write(OFFSETS + 3, 1, gap_ns=2_000)
    rig.write(ENABLES, enables)
    rig.wait(20 * MS)
    data = rig.sample()
    assert (data[3], data[0]) == (accel, gyro)


def test_offset_acts_from_the_next_sample_on() -> None:
    rig = Rig()
    rig.start(gyro=False)
    rig.write(ENABLES, 0x40)
    rig.until(200 * MS + 1)
    rig.write(OFFSETS + 2, 0x10, gap_ns=2_000)
    assert rig.sample()[5] == 16384
    rig.until(210 * MS)
    assert rig.sample()[5] == 16384 + 16 * 64


def test_offset_and_saturation() -> None:
    rig = Rig(motion=lambda t: {"fx": 1.9 * G})
    rig.start(gyro=False)
    rig.write(OFFSETS, 0x7F, gap_ns=2_000)
    rig.write(ENABLES, 0x40)
    rig.wait(20 * MS)
    assert rig.sample()[3] == 32767


# -- FOC ---------------------------------------------------------------------------------------------------


def test_foc_writes_the_negated_errors() -> None:
    rig = Rig(motion=tilted)
    rig.start()
    rig.wait(100 * MS)
    foc(rig, 0x40 | 3 << 4 | 3 << 2 | 1)
    accel = [round(-mg / 3.90625) & 0xFF for mg in (40.0, -20.0, 10.0)]
    gyro = [round(-rate / (31.25 / 512)) for rate in (1.0, -2.0, 0.5)]
    assert list(rig.read(OFFSETS, 6)) == accel + [value & 0xFF for value in gyro]
    assert rig.read(ENABLES)[0] == sum((value >> 8 & 3) << 2 * axis for axis, value in enumerate(gyro))
    rig.write(ENABLES, rig.read(ENABLES)[0] | 0xC0)
    rig.wait(20 * MS)
    data = rig.sample()
    assert data[:3] == pytest.approx((0, 0, 0), abs=0.5 * 31.25 / 512 * 16.4 + 1)
    assert data[3:] == pytest.approx((0, 0, 16384), abs=33)


@pytest.mark.parametrize(("code", "target"), [(1, 1.0), (2, -1.0), (3, 0.0)])
def test_foc_targets(code: int, target: float) -> None:
    rig = Rig(motion=lambda t: {"fy": (target + 0.1) * G})
    rig.start(gyro=False)
    foc(rig, code << 2)
    assert rig.read(OFFSETS, 3) == bytes((0, -26 & 0xFF, 0))


def test_foc_leaves_out_what_is_not_asked_for() -> None:
    rig = Rig(motion=tilted)
    rig.start()
    foc(rig, 3 << 4)
    assert rig.read(OFFSETS, 7) == bytes((-10 & 0xFF, 0, 0, 0, 0, 0, 0))


def test_foc_limits() -> None:
    rig = Rig(motion=lambda t: {"fx": 0.9 * G, "fy": -0.9 * G, "wx": 2.0, "wy": -2.0})
    rig.start()
    foc(rig, 0x40 | 3 << 4 | 3 << 2)
    assert rig.read(OFFSETS, 7) == bytes((0x80, 0x7F, 0x00, 0x00, 0xFF, 0x00, 0x01 << 2 | 0x02))


def test_foc_takes_250_ms_and_shows_its_state() -> None:
    rig = Rig(motion=tilted)
    rig.start()
    foc(rig, 0x70)
    assert rig.read(STATUS)[0] & FOC_READY
    rig.spi(b"\x7e\x03")
    done = rig.time.now + 250 * MS
    assert not rig.read(STATUS)[0] & FOC_READY
    before = rig.read(OFFSETS, 7)
    rig.write(OFFSETS, 0x55, gap_ns=2_000)
    assert rig.read(OFFSETS) == b"\x55"
    rig.until(done - 1)
    assert not rig.read(STATUS)[0] & FOC_READY
    rig.until(max(done, rig.time.now))
    assert rig.read(STATUS)[0] & FOC_READY
    assert rig.read(OFFSETS, 7) == before


def test_foc_does_not_see_offsets_that_are_on() -> None:
    rig = Rig(motion=tilted)
    rig.start()
    rig.write(ENABLES, 0xC0)
    foc(rig, 0x7F)
    first = rig.read(OFFSETS, 7)
    rig.wait(100 * MS)
    foc(rig, 0x7F)
    assert rig.read(OFFSETS, 7) == first


def test_foc_averages_over_its_time() -> None:
    """A 40 Hz vibration of 0.2 g goes away in the mean."""
    rig = Rig(motion=lambda t: {"fx": (0.1 + 0.2 * np.sin(2 * np.pi * 40.0 * t)) * G})
    rig.start(gyro=False)
    foc(rig, 3 << 4)
    assert rig.read(OFFSETS) == bytes((-26 & 0xFF,))


def test_foc_of_a_suspended_sensor_is_reported_and_left_out() -> None:
    rig = Rig(motion=tilted)
    rig.start(gyro=False)
    foc(rig, 0x40)
    assert [report.kind for report in rig.chip.reports] == [ReportKind.PROTOCOL]
    assert rig.read(OFFSETS, 7) == bytes(7)
    assert rig.read(STATUS)[0] & FOC_READY


def test_foc_with_nothing_to_do_is_over_at_once() -> None:
    rig = Rig()
    rig.start(accel=False, gyro=False)
    rig.write(0x7E, 0x03)
    rig.write(0x7E, 0x11, gap_ns=4 * MS)
    assert rig.read(0x02, 2) == b"\x00\x10"


@settings(max_examples=20, deadline=None)
@given(bias=st.floats(-0.49, 0.49), rate=st.floats(-31.0, 31.0))
def test_foc_leaves_at_most_half_a_step(bias: float, rate: float) -> None:
    rig = Rig(motion=lambda t: {"fx": bias * G, "wx": radians(rate)})
    rig.start()
    rig.write(0x43, 4)
    foc(rig, 0x70)
    rig.write(ENABLES, rig.read(ENABLES)[0] | 0xC0)
    rig.wait(20 * MS)
    data = rig.sample()
    assert abs(data[3]) <= 32 + 1
    assert abs(data[0]) <= 31.25 / 1024 * 262.4 + 1


# -- non-volatile memory -----------------------------------------------------------------------------------


def reset(rig: Rig) -> None:
    rig.write(0x7E, 0xB6, gap_ns=1 * MS)
    rig.read(0x7F)


def test_programmed_offsets_survive_reset_and_power_cut() -> None:
    rig = Rig()
    rig.start()
    values = (0x01, 0x82, 0x03, 0x44, 0x55, 0x66, 0xE7)
    rig.write(OFFSETS, *values, gap_ns=2_000)
    rig.write(0x70, 0x02, gap_ns=2_000)
    rig.write(0x6A, 0x02, gap_ns=2_000)
    rig.write(0x7E, 0xA0, gap_ns=25 * MS)
    rig.write(OFFSETS, 0x77, gap_ns=2_000)
    reset(rig)
    assert rig.read(0x70, 8) == bytes((0x02, *values))
    assert rig.read(0x6A) == b"\x00"
    rig.chip.brownout()
    rig.wait(10 * MS)
    rig.read(0x7F)
    assert rig.read(0x70, 8) == bytes((0x02, *values))


def test_what_was_not_programmed_is_lost() -> None:
    rig = Rig()
    rig.start()
    rig.write(OFFSETS, 0x11)
    reset(rig)
    assert rig.read(OFFSETS) == b"\x00"


def test_programming_needs_its_enable() -> None:
    rig = Rig()
    rig.start()
    rig.write(OFFSETS, 0x11)
    rig.write(0x7E, 0xA0, gap_ns=25 * MS)
    assert [report.kind for report in rig.chip.reports] == [ReportKind.PROTOCOL]
    reset(rig)
    assert rig.read(OFFSETS) == b"\x00"


def test_nvm_ready_drops_while_programming() -> None:
    rig = Rig()
    rig.start()
    rig.write(0x6A, 0x02, gap_ns=2_000)
    assert rig.read(STATUS)[0] & 0x10
    rig.write(0x7E, 0xA0, gap_ns=1 * MS)
    assert not rig.read(STATUS)[0] & 0x10
    rig.wait(25 * MS)
    assert rig.read(STATUS)[0] & 0x10


def test_spi_enable_in_the_non_volatile_memory_skips_protocol_detection() -> None:
    rig = Rig()
    rig.start()
    rig.write(0x70, 0x01, gap_ns=2_000)
    rig.write(0x6A, 0x02, gap_ns=2_000)
    rig.write(0x7E, 0xA0, gap_ns=25 * MS)
    rig.write(0x7E, 0xB6, gap_ns=1 * MS)
    assert rig.read(0x00) == b"\xd1"


# -- self-tests --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("attitude", [{"fz": G}, {"fx": -G}, {"fy": 0.7 * G, "fz": 0.7 * G}])
def test_accelerometer_self_test_recipe(attitude: dict[str, float]) -> None:
    rig = Rig(motion=lambda t: attitude)
    rig.start(gyro=False)
    rig.write(0x40, 0x2C, gap_ns=2_000)
    rig.write(0x41, 0x08, gap_ns=2_000)
    rig.write(0x6D, 0x0D, gap_ns=50 * MS)
    positive = rig.sample()[3:]
    rig.write(0x6D, 0x09, gap_ns=50 * MS)
    negative = rig.sample()[3:]
    assert all(n - p > 8192 for n, p in zip(negative, positive, strict=True))
    assert max(abs(value) for value in positive + negative) < 32767
    rig.write(0x6D, 0x00, gap_ns=50 * MS)
    rest = rig.sample()[3:]
    assert rest == tuple(round(attitude.get(name, 0.0) / G * 4096) for name in ("fx", "fy", "fz"))


def test_low_amplitude_deflects_less() -> None:
    rig = Rig()
    rig.start(gyro=False)
    rig.write(0x41, 0x08, gap_ns=2_000)
    readings = []
    for control in (0x01, 0x09):
        rig.write(0x6D, control, gap_ns=50 * MS)
        readings.append(rig.sample()[3])
    assert 0 < readings[0] < readings[1]


def test_gyroscope_self_test() -> None:
    rig = Rig()
    rig.start(accel=False)
    assert not rig.read(STATUS)[0] & 0x02
    rig.spi(b"\x6d\x10")
    done = rig.time.now + 20 * MS
    assert not rig.read(STATUS)[0] & 0x02
    rig.until(done)
    assert rig.read(STATUS)[0] & 0x02


def test_gyroscope_self_test_fails_in_suspend() -> None:
    rig = Rig()
    rig.start(gyro=False)
    rig.write(0x6D, 0x10, gap_ns=50 * MS)
    assert not rig.read(STATUS)[0] & 0x02
