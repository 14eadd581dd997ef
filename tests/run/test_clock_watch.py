"""Clocks that go wrong on a standing car: the sensor's own, the receiver's time pulse. One run holds all."""

from __future__ import annotations

import pytest
from short_drive import broken

from host.record.result import Event, RunRequest
from host.run.runner import run

STRIKES_S, LASTS_S = 40.0, 8.0


@pytest.fixture(scope="module")
def events() -> list[Event]:
    clock = broken("chip-clock", "U2", STRIKES_S, LASTS_S, ppm=-20_000.0)
    pulse = broken("pin-stuck", "GNSS_TIMEPULSE", STRIKES_S, LASTS_S)
    both = f"{clock[:-1]}, {pulse.removeprefix('fault=[')}"
    done = run(RunRequest("car_mems", "static", None, 1, (both, "duration_s=65")))
    return [one for one in done.events if one.source == "board"]


def test_a_sample_clock_that_is_two_percent_off_is_told_with_its_figure(events: list[Event]) -> None:
    """The board's own sensor is 5000 ppm fast: 20,000 less leave 15,000 slow."""
    (told,) = (one for one in events if "IMU clock" in one.text and "off" in one.text)
    assert STRIKES_S < told.at_s < STRIKES_S + LASTS_S
    ppm = int(told.text.split()[2])
    assert ppm == pytest.approx(-15_000, abs=1_500)
    (good,) = (one.at_s for one in events if one.text.startswith("IMU clock is good"))
    assert STRIKES_S + LASTS_S < good < STRIKES_S + LASTS_S + 8.0


def test_a_lost_time_pulse_is_told(events: list[Event]) -> None:
    (lost,) = (one.at_s for one in events if "time pulse lost" in one.text)
    (back,) = (one.at_s for one in events if "time pulse is back" in one.text)
    assert STRIKES_S < lost < STRIKES_S + LASTS_S < back < STRIKES_S + LASTS_S + 8.0
