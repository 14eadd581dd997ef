"""Aiding by what wheels do not do, and by rest."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
from nav_drive import NS, Drive, make_drive, part
from nav_run import run

from firmware.nav import layout as at
from firmware.nav.config import NavConfig
from firmware.nav.flags import STANDSTILL

CONFIG = NavConfig(latency_sigma=0.0)
SMOOTH = """
segment = [
  {{ kind = "rest", duration_s = 25 }}, {{ kind = "reach-speed", duration_s = 5, to_mps = {first} }},
  {{ kind = "turn", duration_s = 8, angle_deg = 60 }}, {{ kind = "reach-speed", duration_s = 4, to_mps = 0 }},
  {{ kind = "rest", duration_s = 8 }}, {{ kind = "reach-speed", duration_s = 3, to_mps = {then} }},
  {{ kind = "cruise", duration_s = 40 }},
]
[place]
latitude_deg = 48.0
longitude_deg = 11.0
height_m = 500.0
[initial]
yaw_deg = 62.0
[trajectory]
blend_s = 0.6
[imu]
preset = "bmi160"
"""


def smooth(folder: Path, first: float, then: float) -> Drive:
    """A drive on a road without any roughness."""
    path = folder / "smooth.toml"
    path.write_text(SMOOTH.format(first=first, then=then))
    return make_drive(path)


def without_gnss(drive: Drive, start_s: float, end_s: float) -> Drive:
    """An outage."""
    drive.epochs = [(t, e) for t, e in drive.epochs if not start_s * NS < t < end_s * NS]
    return drive


def test_aiding_holds_an_outage(town: Drive) -> None:
    """45 s with two turns: several times smaller error, sideways velocity stays small."""
    drive = without_gnss(part(town, 0.0, 150.0), 105.0, 150.0)
    aided = run(drive, CONFIG)
    free = run(drive, dataclasses.replace(CONFIG, constraint=False, standstill=False))
    k = aided.at(149.0)
    assert aided.horizontal[k] < 10.0
    assert aided.horizontal[k] < free.horizontal[k] / 3.0


def test_mounting_angles_are_estimated(town: Drive) -> None:
    """The module sits 3° to the right and 4° nose down in the car: found, and no false velocity remains."""
    yaw, pitch = math.radians(3.0), math.radians(-4.0)
    sy, cy, sp, cp = math.sin(yaw), math.cos(yaw), math.sin(pitch), math.cos(pitch)
    C_b_v = (
        np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1.0]]) @ np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    ).T
    drive = part(town, 0.0, 200.0)
    drive.samples = np.hstack((drive.samples[:, :3] @ C_b_v.T, drive.samples[:, 3:] @ C_b_v.T))
    result = run(drive, CONFIG)
    mounting, sigma = np.degrees(result.biases[-1, 6:8]), np.degrees(result.biases[-1, 15:17])
    # the vehicle's x axis in body axes: yaw −3° and pitch +4°, less what turning the one changes in the other
    np.testing.assert_allclose(mounting, (-3.0, 4.0), atol=0.6)
    assert np.all(sigma < 0.4)
    late = result.t > 120.0
    assert np.max(np.linalg.norm(result.velocity[late], axis=1)) < 0.2
    assert np.max(result.horizontal[late]) < 3.0


def test_backing_out_of_a_parking_place(tmp_path: Path) -> None:
    """The first motion is backwards: yaw is the course turned by 180°."""
    result = run(smooth(tmp_path, first=-4.0, then=8.0), CONFIG)
    aligned = np.argmax(result.mode >= 3)
    assert result.t[aligned] < 31.0
    assert np.max(np.abs(np.degrees(result.attitude[aligned:, 2]))) < 4.0
    assert np.max(np.abs(np.degrees(result.attitude[result.t > 70.0, 2]))) < 1.0


@pytest.mark.parametrize("speed", [0.3, 1.0])
def test_slow_smooth_motion_is_no_rest(tmp_path: Path, speed: float) -> None:
    """Sensors as quiet as at rest, but the car creeps: with GNSS and without."""
    drive = smooth(tmp_path, first=8.0, then=speed)
    creeping = 56.0
    result = run(drive, CONFIG)
    assert not np.any(result.seen("standstill")[result.t > creeping + 3.0])
    assert np.max(np.linalg.norm(result.velocity[result.t > creeping], axis=1)) < 0.2
    lost = run(without_gnss(drive, 65.0, 999.0), CONFIG)
    assert not np.any(lost.seen("standstill")[lost.t > creeping + 3.0])


@pytest.mark.parametrize("braking_s", [7.0, 7.3, 7.6, 7.9])
def test_braking_without_gnss_is_no_rest(tmp_path: Path, braking_s: float) -> None:
    """An even braking on a smooth road is quiet, and the speed passes through the last metre per second."""
    path = tmp_path / "braking.toml"
    rolling = SMOOTH.format(first=8.0, then=8.0).replace(
        '"cruise", duration_s = 40', '"cruise", duration_s = 8'
    )
    stop = f'{{ kind = "reach-speed", duration_s = {braking_s}, to_mps = 0 }}'
    rest = '{ kind = "rest", duration_s = 6 }'
    path.write_text(rolling.replace("]\n[place]", f"  {stop}, {rest}\n]\n[place]"))
    drive = without_gnss(make_drive(path), 50.0, 999.0)
    result = run(drive, CONFIG)
    speed = np.linalg.norm(drive.truth.v_ned[: len(result.t)], axis=1)
    at_rest = result.t > result.t[speed > 0.05][-1]
    assert np.any(result.seen("standstill")[at_rest])
    assert not np.any(result.seen("standstill")[~at_rest & (result.t > 62.0)])
    assert np.linalg.norm(result.velocity[-1]) < 0.05


def test_rest_does_not_tell_tilt_from_accelerometer_bias() -> None:
    """Ten minutes of zero velocity: the tilt is off by bias / g (2.3° at 40 mg), as the covariance says."""
    nees = []
    for seed in (1, 2, 3):
        drive = make_drive("static", seed, duration_s=600.0)
        result = run(drive, dataclasses.replace(CONFIG, initial_yaw=math.radians(62.0)))
        levelled = result.t > 30.0
        assert np.min(result.sigma[levelled, 6:8]) > math.radians(1.8)
        nees.append(np.mean(result.nees[result.nees[:, 0] > 70.0, 1]))
    assert 3.0 < np.mean(nees) < 18.0


def test_rest_holds_everything(town: Drive) -> None:
    """Parked without GNSS for half a minute after a drive: no drift of position or yaw."""
    drive = without_gnss(part(town, 0.0, 180.0), 161.5, 180.0)
    result = run(drive, CONFIG)
    assert result.i[at.EVENT_COUNT + STANDSTILL] > 15
    start, end = result.at(164.0), result.at(179.0)
    assert np.linalg.norm(result.position[end] - result.position[start]) < 0.3
    assert abs(math.degrees(result.attitude[end, 2] - result.attitude[start, 2])) < 0.1
    assert result.sigma[end, 3] < 0.03
