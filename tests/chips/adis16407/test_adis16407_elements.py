"""MSC_CTRL bits 7 and 6: the effect of force on the gyros, and where the accelerometers sit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from adis16407_rig import MS, G, Rig

PLACES = [[4.0, 0.0, 1.0], [0.0, 5.0, -2.0], [3.0, -1.0, 0.0]]


def signed(word: int) -> int:
    return (word & 0x3FFF ^ 0x2000) - 0x2000


def outputs(rig: Rig) -> tuple[list[int], list[int]]:
    """Gyros and accelerometers in counts."""
    rig.wait(200 * MS)
    words = [signed(word) for word in rig.burst()]
    return words[1:4], words[4:7]


def test_force_acts_on_the_gyros_until_bit_7_is_set() -> None:
    rig = Rig(lambda t: {"fx": 2.0 * G, "fy": -G, "fz": 0.0}, g_effect_dps_per_g=0.5, strict=True)
    assert outputs(rig)[0] == [20, -10, 0]  # ±0.5 °/s a g, 0.05 °/s a count
    rig.write(0x38, 0x0086)
    assert outputs(rig)[0] == [0, 0, 0]
    assert rig.read(0x38) == 0x0086


def test_turning_is_felt_where_the_accelerometers_sit_until_bit_6_is_set() -> None:
    turn = np.radians([200.0, -150.0, 250.0])

    def spinning(t: Any) -> dict[str, Any]:
        return {"fz": 0.0, "wx": 200.0, "wy": -150.0, "wz": 250.0}

    rig = Rig(spinning, accelerometer_places_mm=PLACES, strict=True)
    felt = [np.cross(turn, np.cross(turn, np.array(place) * 1e-3))[k] for k, place in enumerate(PLACES)]
    assert outputs(rig)[1] == [round(value / G * 300.0) for value in felt]
    assert max(map(abs, outputs(rig)[1])) > 2
    rig.write(0x38, 0x0046)
    assert outputs(rig)[1] == [0, 0, 0]


def test_angular_acceleration_is_felt_too() -> None:
    rig = Rig(
        lambda t: {"fz": 0.0, "wz": 600.0 * t},
        accelerometer_places_mm=[[0.0, 20.0, 0.0], [0.0] * 3, [0.0] * 3],
    )
    rig.wait(10 * MS)
    # ω̇ × r = −ω̇_z·r_y along x; ω² r has no part along x
    assert outputs(rig)[1][0] == round(-np.radians(600.0) * 0.020 / G * 300.0)


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ({"g_effect_dps_per_g": 11.0}, "g_effect_dps_per_g = 11.0"),
        ({"accelerometer_places_mm": [[1.0]]}, "a place within"),
        ({"accelerometer_places_mm": [[0.0, 0.0, 200.0]] * 3}, "±100 mm"),
    ],
)
def test_what_cannot_be_is_refused(parameters: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        Rig(**parameters)
