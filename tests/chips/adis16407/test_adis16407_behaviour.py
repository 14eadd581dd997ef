"""Commands with their times, flash, self-test, diagnosis, alarms, pins, sleep."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from adis16407_rig import MS, SECOND, START_UP, G, Rig, instant
from hypothesis import given, settings
from hypothesis import strategies as some

from boards.chips.registers import ReportKind


def signed(word: int, bits: int = 14) -> int:
    value = word & ((1 << bits) - 1)
    return value - (1 << bits) if value >> (bits - 1) else value


def turning(_t: Any) -> dict[str, Any]:
    return {"wx": 3.0, "wy": -2.5, "wz": 0.0}


# -- commands ------------------------------------------------------------------------------------------


def test_auto_null_takes_50_ms_and_goes_into_the_flash() -> None:
    rig = Rig(turning)
    done = rig.time.now + 50 * MS
    rig.word(0xC201)
    rig.until(done - 100_000)
    assert [rig.read(a) for a in (0x1E, 0x00)] == [0, 0]
    rig.until(done)
    assert [signed(rig.read(a), 13) for a in (0x1E, 0x20, 0x22)] == [-240, 200, 0]
    rig.wait(2 * MS)
    assert [signed(word) for word in rig.burst()[1:4]] == [0, 0, 0]
    assert rig.read(0x00) == 1
    rig.chip.brownout()
    rig.wait(START_UP)
    assert signed(rig.read(0x1E), 13) == -240
    rig.word(0xC201)  # a second one keeps what is nulled
    rig.wait(60 * MS)
    assert signed(rig.read(0x1E), 13) == -240


def test_precision_null_is_the_mean_over_30_s() -> None:
    rig = Rig(lambda t: {"wx": 2.0 + 10.0 * np.sin(2.0 * np.pi * t / 3.0), "wy": -1.0 + 0.01 * t})
    start = rig.time.now
    rig.word(0xC210)
    rig.until(start + 30 * SECOND - 100_000)
    assert rig.read(0x1E) == 0
    rig.until(start + 30 * SECOND)
    x, y = (signed(rig.read(a), 13) for a in (0x1E, 0x20))
    assert x == pytest.approx(-2.0 / 0.0125, abs=1.0)
    assert y == pytest.approx((1.0 - 0.01 * (start * 1e-9 + 15.0)) / 0.0125, abs=1.0)
    assert rig.read(0x00) == 1


def test_restore_brings_back_the_factory_calibration_only() -> None:
    rig = Rig()
    for address, value in ((0x1E, 7), (0x24, 8), (0x2A, 9), (0x30, 10), (0x44, 11)):
        rig.write(address, value)
    rig.word(0xC202)
    rig.wait(70 * MS)
    assert rig.read(0x1E) == 7
    rig.wait(6 * MS)
    assert [rig.read(a) for a in (0x1E, 0x24, 0x2A, 0x30, 0x44)] == [0, 0, 0, 0x0800, 11]


def test_a_command_while_another_is_at_work_is_dropped() -> None:
    rig = Rig()
    rig.word(0xC208)
    rig.wait(10 * MS)
    rig.word(0xC201)
    rig.wait(200 * MS)
    assert rig.read(0x00) == 1
    assert [r.kind for r in rig.chip.reports] == [ReportKind.DROPPED]


def test_flash_wear_is_counted_and_told() -> None:
    rig = Rig(flash_count=9_999)
    for count in (10_000, 10_001):
        rig.word(0xC208)
        rig.wait(80 * MS)
        assert rig.read(0x00) == count
    assert "endurance" in str(rig.chip.reports[0])


def test_supply_cut_during_an_update_breaks_the_checksum() -> None:
    rig = Rig()
    rig.write(0x1E, 0x0111)
    rig.word(0xC208)
    rig.wait(30 * MS)
    rig.chip.brownout()
    rig.wait(START_UP)
    assert rig.read(0x1E) == 0  # factory settings
    assert rig.read(0x40) == 0x0040
    rig.word(0xB908)  # memory test
    rig.wait(100 * MS)
    assert rig.read(0x40) == 0x0040
    rig.word(0xC208)
    rig.wait(100 * MS)
    rig.word(0xB908)
    rig.wait(100 * MS)
    assert rig.read(0x40) == 0


@pytest.mark.parametrize(("volts", "flag"), [(4.74, 0x01), (5.26, 0x02)])
def test_supply_out_of_range(volts: float, flag: int) -> None:
    rig = Rig()
    rig.chip.supply_v = volts
    assert rig.read(0x40) == 0
    rig.wait(2 * MS)
    assert all(word & 0x4000 for word in rig.burst())
    assert rig.read(0x40) == flag
    rig.word(0xC208)
    rig.wait(100 * MS)
    assert rig.read(0x40) == 0x0004 | flag  # the flash was not written
    assert rig.read(0x00) == 0
    rig.chip.supply_v = 5.0
    rig.read(0x40)
    rig.wait(2 * MS)
    assert rig.read(0x40) == 0
    assert rig.read(0x02) & 0x4FFF == 0x814


def test_dac_is_latched() -> None:
    rig = Rig()
    rig.write(0x4E, 0x0800)
    assert rig.chip.aux_dac_v == 0.0
    rig.word(0xC204)
    assert rig.chip.aux_dac_v == pytest.approx(0x800 * 0.806e-3)


FLAGS = {
    "accel_z": 0x8020, "accel_y": 0x4020, "accel_x": 0x2020,
    "gyro_z": 0x1020, "gyro_y": 0x0820, "gyro_x": 0x0420, "barometer": 0x00A0,
}  # fmt: skip


@pytest.mark.parametrize(("part", "flags"), FLAGS.items())
def test_self_test_finds_what_is_broken(part: str, flags: int) -> None:
    rig = Rig(defects=[part])
    assert rig.read(0x40) == 0
    rig.word(0xB904)
    rig.wait(50 * MS)
    assert rig.read(0x40) == flags
    assert rig.read(0x40) == 0
    rig.chip.break_parts()
    rig.word(0xB904)
    rig.wait(50 * MS)
    assert rig.read(0x40) == 0


def test_over_range_between_two_looks_is_kept() -> None:
    rig = Rig(lambda t: {"fx": 20.0 * G * ((t > 3.0) & (t < 3.01))})
    rig.wait(20 * SECOND)
    assert rig.read(0x04) & 0x4000
    assert rig.read(0x40) == 0x0010
    rig.wait(5 * MS)
    assert rig.read(0x40) == 0


@pytest.mark.parametrize(
    ("option", "value", "message"),
    [
        ("serial_number", 70_000, "serial_number = 70000"),
        ("lot_id", -1, "lot_id = -1"),
        ("supply_v", 12.0, "supply_v = 12.0"),
        ("defects", ["gyro"], "defect 'gyro'; possible: accel_z"),
    ],
)
def test_impossible_units(option: str, value: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Rig(**{option: value})


# -- alarms --------------------------------------------------------------------------------------------

# output of the alarm's source (code), value felt, counts
SOURCES = [
    (1, {}, 2068), (2, {"wx": 20.0}, 400), (3, {"wy": -20.0}, -400), (4, {"wz": 1.0}, 20),
    (5, {"fx": G}, 300), (6, {"fy": -G}, -300), (7, {"fz": G}, 300),
    (8, {"bx": 0.2}, 400), (9, {"by": -0.2}, -400), (10, {"bz": 0.1}, 200),
    (11, {"pressure": 900.0}, 11250), (12, {"temperature": 11.4}, -100), (13, {}, 1241),
]  # fmt: skip


@pytest.mark.parametrize(("code", "felt", "counts"), SOURCES)
@pytest.mark.parametrize("which", [0, 1])
def test_alarm_sources_and_thresholds(code: int, felt: dict[str, float], counts: int, which: int) -> None:
    """Strictly greater, strictly less."""
    for above in (True, False):
        for margin in (-1, 0, 1):
            rig = Rig(lambda t: felt, aux_adc_v=1.0)
            rig.write(0x44 + 2 * which, above << 15 | (counts + margin) & 0x3FFF)
            rig.write(0x4C, code << (8 + 4 * which))
            rig.wait(2 * MS)
            active = counts > counts + margin if above else counts < counts + margin
            assert rig.read(0x40) == (0x0100 << which if active else 0)


@settings(max_examples=25, deadline=None)
@given(some.integers(1, 255), some.integers(-40, 40), some.booleans(), some.booleans())
def test_rate_of_change(samples: int, threshold: int, above: bool, steps_up: bool) -> None:
    """Against a plain loop over the samples, as they can be read one by one."""

    def motion(t: Any) -> dict[str, Any]:
        return {"fx": (1.0 if steps_up else -1.0) * 10.0 * G * np.clip((t - 0.5) / 0.2, 0.0, 1.0)}

    rig, plain = Rig(motion), Rig(motion)
    for each in (rig, plain):
        each.write(0x3C, 0x0400)
        each.until(START_UP + 20 * MS)
    rig.write(0x44, above << 15 | threshold & 0x3FFF)
    rig.word(0xC800 | samples)
    rig.write(0x4C, 0x0550)
    seen: list[int] = []
    first, raised = None, False
    for n in range(1, 600):
        plain.until(instant(n))
        seen.append(signed(plain.read(0x0A)))
        if n * 1_220_703 + START_UP <= rig.time.now or len(seen) <= samples:
            continue
        change = seen[-1] - seen[-1 - samples]
        raised = change > samples * threshold if above else change < samples * threshold
        if raised:
            first = n
            break
    if first is None:
        rig.until(instant(599))
        assert rig.read(0x40) & 0x0100 == 0
        return
    rig.until(max(rig.time.now, instant(first)))
    assert rig.read(0x40) & 0x0100


def test_filtered_and_unfiltered_compare() -> None:
    for filtered, expected in ((0x10, 0), (0x00, 0x0100)):
        spike = instant(300) * 1e-9
        rig = Rig(lambda t, spike=spike: {"wx": 100.0 * (np.abs(t - spike) < 1e-6)})
        rig.write(0x44, 0x8000 | 1000)
        rig.write(0x4C, 0x0200 | filtered)
        rig.until(instant(400))
        assert rig.read(0x40) == expected


def test_codes_without_an_output_are_off_and_told() -> None:
    rig = Rig()
    rig.write(0x4C, 0xEF00)
    rig.wait(5 * MS)
    assert rig.read(0x40) == 0
    assert {r.kind for r in rig.chip.reports} == {ReportKind.RESERVED_VALUE}


@pytest.mark.parametrize("pin", [0, 1])
@pytest.mark.parametrize("high", [0, 1])
def test_alarm_pin(pin: int, high: int) -> None:
    name = ("DIO1", "DIO2")[pin]
    rig = Rig(lambda t: {"fx": 5.0 * G * (t > 0.5)}, listen=name)
    rig.write(0x38, 0)
    rig.write(0x44, 0x8000 | 900)
    rig.write(0x4C, 0x0514 | high << 1 | pin)
    assert rig.nets[name].level == (not high)
    rig.edges[name].clear()
    rig.until(600 * MS)
    ((when, level),) = rig.edges[name]
    assert level == bool(high)
    assert 500 * MS < when < 505 * MS
    assert rig.read(0x40) == 0x0100
    assert rig.edges[name][1][1] == (not high)  # until the next sample
    rig.wait(2 * MS)
    assert rig.nets[name].level == bool(high)


# -- pins ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("control", range(8))
def test_data_ready_pin(control: int) -> None:
    rig = Rig(listen="DIO1 DIO2")
    rig.word(0xB800 | control)
    for edges in rig.edges.values():
        edges.clear()
    rig.until(instant(1) - 1)
    for edges in rig.edges.values():
        edges.clear()
    rig.until(instant(5) + 500_000)
    name = ("DIO1", "DIO2")[control & 1]
    other = ("DIO2", "DIO1")[control & 1]
    active = [when for when, level in rig.edges[name] if level == bool(control & 2)]
    assert active == ([instant(n) for n in range(1, 6)] if control & 4 else [])
    assert rig.edges[other] == []
    if control & 4:
        assert rig.nets[name].level == (not control & 2)


def test_general_purpose_pins() -> None:
    rig = Rig()
    rig.write(0x38, 0)
    rig.nets["DIO3"].set(True)
    assert rig.read(0x36) == 0x0400
    rig.write(0x36, 0x0B03)
    assert [rig.nets[f"DIO{k}"].level for k in (1, 2)] == [True, True]
    assert rig.read(0x36) == 0x0703  # DIO4 is an input and low
    rig.write(0x36, 0x0103)
    assert [rig.nets[f"DIO{k}"].level for k in (1, 2, 3)] == [True, False, True]


# -- sleep ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("units", [1, 7])
def test_sleep_for_a_time(units: int) -> None:
    rig = Rig(listen="DIO1")
    rig.wait(10 * MS)
    asleep = rig.time.now
    rig.edges["DIO1"].clear()
    rig.word(0xBE00 | units)
    rig.wait(100 * MS)
    assert rig.word(0x5600) == 0
    assert [r.kind for r in rig.chip.reports] == [ReportKind.TIMING]
    awake = asleep + units * 500 * MS + 4 * MS
    rig.until(awake + 10 * MS)
    assert rig.edges["DIO1"][0] == (awake, True)
    assert rig.read(0x56) == 0x4017
    assert rig.read(0x3E) == 0


def test_sleep_until_chip_select() -> None:
    rig = Rig()
    rig.word(0xBF01)
    rig.wait(50 * SECOND)
    selected = rig.time.now
    assert rig.word(0x5600) == 0
    assert rig.chip.reports == []
    rig.until(selected + 4 * MS - 1)
    assert rig.word(0x5600) == 0
    rig.until(selected + 5 * MS)
    assert rig.read(0x56) == 0x4017


@pytest.mark.parametrize("low", ["supply", "RST"])
def test_pins_are_low_without_supply_and_in_reset(low: str) -> None:
    rig = Rig(listen="DIO1 DIO2")
    rig.nets["RST"].set(True)
    rig.write(0x38, 0x0004)  # data ready, active low, DIO1
    rig.write(0x36, 0x0202)
    assert rig.nets["DIO1"].level
    assert rig.nets["DIO2"].level
    if low == "supply":
        rig.chip.power(False)
    else:
        rig.nets["RST"].set(False)
    rig.wait(1 * SECOND)
    assert not rig.nets["DIO1"].level
    assert not rig.nets["DIO2"].level


def test_settings_survive_sleep() -> None:
    rig = Rig()
    rig.write(0x1E, 0x0123)
    rig.word(0xBE01)
    rig.wait(600 * MS)
    assert rig.read(0x1E) == 0x0123
