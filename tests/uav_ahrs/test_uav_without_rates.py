"""Gyros that tell nothing, or what cannot be: noticed, said, bridged by force and field."""

from __future__ import annotations

import pytest
from uav_runs import fly

FROM_S, LASTS_S = 20.0, 8.0
LOST, BACK = "rates lost, attitude uncertain", "rates are back"


def gyro_fault(kind: str, more: str = "") -> str:
    where = f'kind="{kind}", target="U2", at_s={FROM_S}, duration_s={LASTS_S}'
    return f'fault=[{{{where}, parameters={{quantity="gyro"{more}}}}}]'


@pytest.mark.parametrize("profile", ["float32", "fixed"])
@pytest.mark.parametrize("kind", ["sensor-saturated", "sensor-frozen"])
def test_gyros_out_for_eight_seconds(kind: str, profile: str) -> None:
    """At rest; three axes at 300 deg/s would be a turn of 4,000 degrees."""
    flown = fly("static", profile, "duration_s=45", gyro_fault(kind), "expect={}")
    assert flown.said(LOST, FROM_S) < FROM_S + 1.5
    assert FROM_S + LASTS_S < flown.said(BACK, FROM_S) < FROM_S + LASTS_S + 2.0
    assert flown.worst_deg(6.0, 45.0) < 6.0
    assert flown.worst_deg(FROM_S + LASTS_S + 6.0, 45.0) < 1.0


@pytest.mark.parametrize("profile", ["float32", "fixed"])
def test_gyros_that_drift_away_are_told(profile: str) -> None:
    """0.6 deg/s more each second: no bias of a sound gyro, and force and field contradict it."""
    flown = fly("static", profile, "duration_s=45", gyro_fault("sensor-drift", ", rate=0.01"), "expect={}")
    assert flown.said("gyros contradict force and field", FROM_S) < FROM_S + LASTS_S + 2.0
    t, mode = flown.column("t_s"), flown.column("mode")
    assert 4 in mode[(t > FROM_S) & (t < FROM_S + LASTS_S + 4.0)]


@pytest.mark.parametrize("profile", ["float32", "fixed"])
def test_a_sensor_without_any_noise_is_not_called_frozen_for_it(profile: str) -> None:
    """Turning evenly, its rates stand too."""
    perfect = ("imu.preset=perfect", "duration_s=40")
    turn = ('segment=[{kind="rest",duration_s=10.0},{kind="circle",duration_s=20.0,rate_dps=18.0},'
            '{kind="rest",duration_s=10.0}]')  # fmt: skip
    flown = fly("static", profile, *perfect, turn, "expect={}")
    assert not [words for _, words in flown.words() if LOST in words or "contradict" in words]
    assert flown.worst_deg(6.0, 40.0) < 0.5
