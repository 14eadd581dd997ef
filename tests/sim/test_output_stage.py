"""Non-linearity, bandwidth, range and resolution of inertial sensors, against answers on paper."""

from __future__ import annotations

import math

import numpy as np
import pytest
from standing import SECOND, sampled, world

RATE_HZ = 1000
G = 9.80665


def turning(rate_dps, **imu):
    circle = [{"kind": "circle", "duration_s": 100.0, "rate_dps": rate_dps}]
    return world(segment=circle, duration_s=100.0, imu={"preset": "perfect", **imu}).imu("U1")


def felt(sensor, seconds=2.0, start_s=10.0):
    return sampled(sensor, RATE_HZ, seconds, start_s=start_s)


def test_a_parabola_deviates_from_its_best_line_by_what_is_said():
    """Over a table of rates ±300 °/s the deviation from the best (least largest) straight line."""
    rates = np.arange(-300.0, 301.0, 50.0)
    errors = {"nonlinearity_percent": [0.0, 0.0, 0.1], "nonlinearity_range_dps": 300.0}
    found = []
    for rate in rates.tolist():
        clean, bent = felt(turning(rate), 0.1), felt(turning(rate, gyro=errors), 0.1)
        found.append(math.degrees((bent - clean)[:, 5].mean()))
        assert (bent[:, :5] == clean[:, :5]).all()
    middle = 0.5 * (max(found) + min(found))  # of a parabola the best line is level
    deviation = max(abs(one - middle) for one in found)
    draw = abs(found[-1]) / (2.0 * 0.001 * 300.0)
    assert deviation == pytest.approx(0.001 * 300.0 * draw, rel=1e-4)
    assert np.allclose(found, np.array(rates) ** 2 * found[-1] / 300.0**2, atol=1e-4)


def test_range_and_resolution():
    gyro = {"range_dps": 90.0, "resolution_dps": 0.5}
    inside = np.degrees(felt(turning(59.9, gyro=gyro))[:, 5])  # 60.2 between its flanks
    beyond = np.degrees(felt(turning(-120.0, gyro=gyro))[:, 5])
    assert inside == pytest.approx(60.0, abs=1e-9)
    assert beyond == pytest.approx(-90.0, abs=1e-9)
    coarse = felt(turning(0.0, accelerometer={"range_g": 0.5, "resolution_mg": 10.0}))
    assert coarse[:, 2] == pytest.approx(-0.5 * G, abs=1e-9)


@pytest.mark.parametrize("bandwidth_hz", [5.0, 40.0])
def test_bandwidth_is_that_of_a_first_order_low_pass(bandwidth_hz):
    """White noise n per √Hz leaves it with n √(π B / 2); a swing of f is left by 1 / √(1 + (f/B)²)."""
    noisy = world(
        imu={"preset": "perfect", "gyro": {"noise_dps_per_rthz": 0.01, "bandwidth_hz": bandwidth_hz}}
    ).imu("U1")
    spread = np.degrees(sampled(noisy, RATE_HZ, 60, 500.0)[:, 3:6]).std(axis=0)
    assert spread == pytest.approx([0.01 * math.sqrt(math.pi * bandwidth_hz / 2.0)] * 3, rel=0.08)
    shaken = {"vibration": {"coning_deg": 1.0, "coning_hz": 10.0, "always": True}}
    full, less = (
        sampled(world(**shaken, imu={"preset": "perfect", "gyro": gyro}).imu("U1"), RATE_HZ, 4, start_s=1.0)
        for gyro in ({}, {"bandwidth_hz": bandwidth_hz})
    )
    ratio = less[2000:, 3].std() / full[2000:, 3].std()
    assert ratio == pytest.approx(1.0 / math.sqrt(1.0 + (10.0 / bandwidth_hz) ** 2), rel=0.02)


def test_blocks_leave_no_trace():
    gyro = {"noise_dps_per_rthz": 0.01, "bandwidth_hz": 20.0, "resolution_dps": 0.01}
    times = np.arange(1, 3001) * (SECOND // RATE_HZ)
    whole = world(imu={"preset": "perfect", "gyro": gyro}).imu("U1").sample(times, 500.0)
    sensor = world(imu={"preset": "perfect", "gyro": gyro}).imu("U1")
    parts = np.vstack([sensor.sample(times[k : k + 700], 500.0) for k in range(0, 3000, 700)])
    assert (parts == whole).all()
