"""The temperature register: scale, refresh, the code for invalid."""

from __future__ import annotations

from struct import unpack

import pytest
from bmi160_rig import MS, Rig


def temperature(rig: Rig) -> int:
    return int(unpack("<h", rig.read(0x20, 2))[0])


@pytest.mark.parametrize(("celsius", "counts"), [(23.0, 0), (25.0, 1024), (-10.0, -16896), (86.0, 32256)])
def test_temperature_scale(celsius: float, counts: int) -> None:
    rig = Rig(motion=lambda t: {"temperature": celsius})
    rig.start()
    rig.wait(20 * MS)
    assert temperature(rig) == counts


@pytest.mark.parametrize(("celsius", "counts"), [(200.0, 0x7FFF), (-200.0, -0x7FFF)])
def test_temperature_never_shows_the_code_for_invalid(celsius: float, counts: int) -> None:
    rig = Rig(motion=lambda t: {"temperature": celsius})
    rig.start()
    rig.wait(20 * MS)
    assert temperature(rig) == counts


@pytest.mark.parametrize(("gyro", "refresh_ms"), [(True, 10), (False, 1280)])
def test_temperature_refresh(gyro: bool, refresh_ms: int) -> None:
    rig = Rig(motion=lambda t: {"temperature": 23.0 + t})
    rig.start(gyro=gyro)
    for step in range(40):
        rig.until(3_000 * MS + step * 77 * MS)
        refreshed = rig.time.now // (refresh_ms * MS) * refresh_ms
        assert temperature(rig) == round(refreshed / 1000 * 512)


def test_temperature_reads_zero_before_its_first_refresh() -> None:
    rig = Rig()
    rig.start(accel=False, gyro=False)
    assert temperature(rig) == 0
    rig.until(1_280 * MS)
    assert temperature(rig) == 1024
