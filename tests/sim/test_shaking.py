"""Sway and vibration have the size and the axis that the scenario gives them."""

import numpy as np
import pytest
from standing import PLACE

from host.sim.scenario.load import scenario_from
from host.sim.simulated import SimulatedVehicle

SECOND = 1_000_000_000


def cruise(speed, seed=1, **tables):
    """Truth and perfect sensors of 400 s straight on."""
    data = {
        "place": PLACE,
        "initial": {"speed_mps": speed, "yaw_deg": 30.0},
        "segment": [{"kind": "cruise", "duration_s": 400.0}],
        "imu": {"preset": "perfect"},
        **tables,
    }
    vehicle = SimulatedVehicle(scenario_from(data, "cruise", "cruise"), seed)
    times = np.arange(0, 400 * SECOND, 20_000_000)
    return vehicle.truth(times), vehicle.imu("a", np.eye(3), np.zeros(3)).sample(times, 25.0)


@pytest.mark.parametrize("angle", ["roll", "pitch"])
def test_sway_has_its_size_and_touches_no_other_angle(angle):
    truth, _ = cruise(20.0, sway={f"{angle}_deg": 0.5})
    other = "pitch" if angle == "roll" else "roll"
    assert np.degrees(getattr(truth, angle)).std() == pytest.approx(0.5 * 400 / 404, rel=0.1)
    assert np.ptp(getattr(truth, other)) == 0.0
    assert np.ptp(truth.v_ned[:, 2]) == 0.0  # the springs sway, the road does not


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_vibration_has_its_acceleration_along_its_axis(axis):
    _, felt = cruise(20.0, vibration={f"{'xyz'[axis]}_mps2": 1.5})
    spread = felt[:, :3].std(axis=0)
    assert spread[axis] == pytest.approx(1.5 * 400 / 404, rel=0.1)
    assert np.delete(spread, axis).max() < 1e-4


def test_shaking_grows_with_speed_and_is_half_at_its_half_speed():
    vibration = {"z_mps2": 2.0, "half_speed_mps": 4.0}
    slow, fast = cruise(4.0, vibration=vibration)[1], cruise(400.0, vibration=vibration)[1]
    assert slow[:, 2].std() / fast[:, 2].std() == pytest.approx(0.5, rel=0.01)
    assert cruise(0.0, vibration=vibration)[1][:, 2].std() < 1e-12
    always = cruise(0.0, vibration={**vibration, "always": True})[1]
    assert always[:, 2].std() == pytest.approx(fast[:, 2].std(), rel=0.01)


def test_seeds_shake_differently():
    first, second = (cruise(20.0, seed, vibration={"z_mps2": 1.0})[1] for seed in (1, 2))
    assert abs(np.corrcoef(first[:, 2], second[:, 2])[0, 1]) < 0.3
