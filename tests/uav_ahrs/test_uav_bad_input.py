"""Trouble on bus and sensor: noticed, said on the link, bridged, recovered from."""

from __future__ import annotations

import pytest
from uav_runs import Flown, fly

FAULTS = (
    ('kind="spi-word-slip", target="imu", at_s=20.0, duration_s=2.0, parameters={bits=16}', "words slip"),
    ('kind="chip-halt", target="U2", at_s=30.0, duration_s=2.0', "stale"),
    ('kind="chip-flags", target="U2", at_s=40.0, duration_s=3.0, parameters={flags=0x0420}', "self-test"),
    ('kind="chip-flags", target="U2", at_s=50.0, duration_s=3.0, parameters={flags=0x0100}', "alarm"),
    ('kind="chip-supply", target="U2", at_s=60.0, duration_s=3.0, parameters={volts=4.7}', "low"),
    ('kind="chip-supply", target="U2", at_s=70.0, duration_s=3.0, parameters={volts=5.3}', "high"),
    ('kind="sensor-stuck", target="U2", at_s=80.0, duration_s=5.0, parameters={quantity="mag"}', "field"),
    ('kind="spi-missing", target="imu", at_s=95.0, duration_s=2.0', "ones"),
    ('kind="spi-missing", target="imu", at_s=105.0, duration_s=2.0, parameters={level=false}', "zeros"),
    ('kind="chip-wrong-id", target="U2", at_s=115.0, duration_s=3.0', "id"),
    ('kind="chip-reset", target="U2", at_s=125.0', "reset"),
    ('kind="spi-register", target="imu", at_s=135.0, duration_s=0.02,'
     ' parameters={register=0x04,value=0x97FF}', "one rate at its end"),
    ('kind="nav-nan", target="dsp", at_s=145.0', "nan"),
)  # fmt: skip
ALL = ", ".join(f'{{{fault}, name="{name}"}}' for fault, name in FAULTS)


@pytest.fixture(scope="module")
def struck() -> Flown:
    """At rest, one fault after the other."""
    return fly("static", None, "duration_s=160", f"fault=[{ALL}]", "expect={}")


def test_all_of_them_struck(struck: Flown) -> None:
    assert [fault.name for fault in struck.result.faults if not fault.fired] == []


ERROR = "sensor: the chip reports an error: "
SAID = {
    "words slip": (20.0, "bus: words have slipped", "bus: words in their places again"),
    "stale": (30.0, "sensor: no new samples", "sensor: new samples again"),
    "self-test": (40.0, ERROR + "self-test error, gyro x failed", "sensor: well again"),
    "alarm": (50.0, "sensor: an alarm is active: alarm 1", "sensor: well again"),
    "low": (60.0, "sensor: supply out of range", "sensor: supply in range again"),
    "low, as the chip says": (60.0, ERROR + "supply below 4.75 V", "sensor: well again"),
    "high": (70.0, "sensor: supply out of range", "sensor: supply in range again"),
    "field": (80.0, "sensor: magnetic field missing or disturbed", "sensor: magnetic field is back"),
    "ones": (95.0, "sensor: no answer", "sensor: answers again"),
    "zeros": (105.0, "sensor: no answer", "sensor: answers again"),
    "id": (115.0, "sensor: wrong product id: 0x00EE", "sensor: well again"),
    "reset": (125.0, "sensor: no answer", "sensor: answers again"),
    "nan": (145.0, "state not a number, the last sound one put back", "mode: navigating"),
}  # fmt: skip


@pytest.mark.parametrize("name", SAID)
def test_it_is_said_and_so_is_its_end(struck: Flown, name: str) -> None:
    at_s, begin, end = SAID[name]
    assert struck.said(begin, at_s) < at_s + 1.7
    assert struck.said(end, at_s) < at_s + 8.0


def test_attitude_is_bridged_and_back(struck: Flown) -> None:
    """At rest nothing is missed; nothing may be made up either."""
    assert struck.worst_deg(6.0, 160.0) < 1.5
    assert struck.worst_deg(150.0, 160.0) < 0.6
    assert struck.result.metrics["availability"] == 1.0


def test_long_silence_is_called_degraded(struck: Flown) -> None:
    t, mode = struck.column("t_s"), struck.column("mode")
    for at_s in (20.0, 95.0, 105.0):
        assert 4 in mode[(t > at_s + 0.5) & (t < at_s + 3.0)]
        assert set(mode[(t > at_s + 6.0) & (t < at_s + 9.5)]) == {3}


def test_solutions_go_on_meanwhile(struck: Flown) -> None:
    t = struck.column("t_s")
    assert max(t[1:] - t[:-1]) < 0.2


def test_a_sensor_that_is_not_there_at_first(capfd: pytest.CaptureFixture[str]) -> None:
    fault = 'fault=[{kind="spi-missing", target="imu", at_s=0.0, duration_s=5.0}]'
    flown = fly("static", None, "duration_s=25", fault, "expect={}")
    assert flown.said("sensor: nobody answers: 0xFFFF") < 1.0
    assert 5.0 < flown.said("sensor: set up anew") < 7.0
    assert flown.said("mode: navigating") < 13.0
    assert flown.worst_deg(13.0, 25.0) < 1.0


def test_another_chip_in_its_place() -> None:
    fault = 'fault=[{kind="chip-wrong-id", target="U2", at_s=0.0, parameters={id=16405}}]'
    flown = fly("static", None, "duration_s=12", fault, "expect={}")
    assert flown.said("sensor: wrong product id: 0x4015") < 1.0
    assert flown.result.metrics["seconds_with_solution"] == 0


def test_a_self_test_that_fails_is_said_at_power_on() -> None:
    broken = 'board.chips.U2.parameters.defects=["gyro_y", "accel_x"]'
    flown = fly("static", None, "duration_s=12", broken, "expect={}")
    words = flown.words()[0][1]
    assert words.startswith("sensor: the self-test failed: ")
    assert "gyro y failed" in words
    assert "accelerometer x failed" in words


def test_without_a_magnetometer_the_heading_is_as_given() -> None:
    fault = 'fault=[{kind="sensor-stuck", target="U2", at_s=0.0, parameters={quantity="mag"}}]'
    flown = fly("static", None, "duration_s=20", fault, "expect={}")
    assert flown.said("no magnetic field: heading as given") < 7.0
    yaw = flown.column("yaw_deg")
    assert abs((yaw[-1] + 180.0) % 360.0 - 180.0) < 1.0  # the profile gives none: north


def test_the_documents_supply_word() -> None:
    """0xC7A7: new data, error or alarm, 4.737 V, which is below the limit (its figure 5-3)."""
    fault = (
        'fault=[{kind="spi-register", target="imu", at_s=10.0, duration_s=3.0,'
        " parameters={register=0x02, value=0xC7A7}}]"
    )
    flown = fly("static", None, "duration_s=16", fault, "expect={}")
    assert flown.said("sensor: supply out of range", 10.0) < 10.3
    flags = flown.column("flags")[(flown.column("t_s") > 11.0) & (flown.column("t_s") < 12.0)]
    assert {int(one) >> 16 & 0b110 for one in flags} == {0b110}  # chip_error and supply


@pytest.mark.parametrize("profile", ["float32", "fixed"])
def test_a_processor_that_starts_again_in_flight_aligns_in_motion(profile: str) -> None:
    fault = 'fault=[{kind="cpu-reset", target="dsp", at_s=50.0}]'
    flown = fly("flight", profile, "duration_s=100", fault, "expect={}")
    assert flown.said("alignment: no rest to be had, aligning in motion", 50.0) < 66.0
    assert flown.said("mode: navigating", 50.0) < 68.0
    assert flown.worst_deg(90.0, 100.0) < 5.0
