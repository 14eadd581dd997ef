"""From switching on to navigating: at rest, in motion, backwards, with a yaw that is given or wrong."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
from nav_drive import Drive, make_drive, part
from nav_run import Result, run

from firmware.nav.config import NavConfig
from firmware.nav.flags import LEVELLING, NAVIGATING, WAITING_FOR_HEADING

CONFIG = NavConfig(latency_sigma=0.0)
BIASED_TILT_DEG = 4.0
"""40 mg of bias, two axes, 1.2 σ: what levelling may be off."""


def degrees(result: Result, t: float) -> np.ndarray:
    """Errors of roll, pitch, yaw at a time."""
    return np.degrees(result.attitude[result.at(t)])


def test_rest_levels_then_course_gives_yaw(town: Drive) -> None:
    """Mode by mode: levelling for ten seconds, waiting for heading, navigating once the car has 3 m/s."""
    result = run(part(town, 0.0, 100.0), CONFIG)
    assert result.mode[result.at(5.0)] == LEVELLING
    assert result.mode[result.at(60.0)] == WAITING_FOR_HEADING
    assert result.sigma[result.at(60.0), 8] == pytest.approx(math.pi, rel=1e-6)
    speed = np.linalg.norm(town.truth.v_ned[: len(result.t)], axis=1)
    aligned = int(np.argmax(result.mode == NAVIGATING))
    assert 2.5 < speed[aligned] < 4.1
    assert np.all(np.abs(degrees(result, 60.0)[:2]) < BIASED_TILT_DEG)
    assert abs(degrees(result, result.t[aligned])[2]) < 3.0


def test_gyro_bias_learnt_at_rest_has_no_earth_rate(town: Drive) -> None:
    """The mean rate at rest holds 7e-5 rad/s of the Earth; the bias must not, once yaw is known."""
    result = run(part(town, 0.0, 80.0), CONFIG)
    k = result.at(79.0)
    error = result.biases[k, :3] - town.truth.bias_g[k]
    assert np.all(np.abs(error) < 4.0 * result.biases[k, 9:12])
    assert np.linalg.norm(error) < 2.0e-4


@pytest.mark.parametrize(("start", "moving"), [(95.0, "straight"), (109.0, "before a turn")])
def test_aligns_in_motion(town: Drive, start: float, moving: str) -> None:
    """No rest at all, turn-on biases of 0.5 °/s and 40 mg: navigating after some seconds, settled in 15."""
    result = run(part(town, start, 160.0), CONFIG)
    aligned = result.t[np.argmax(result.mode == NAVIGATING)]
    assert aligned < start + 9.0, moving
    assert WAITING_FOR_HEADING not in result.mode
    settled = result.t > aligned + 15.0
    assert np.max(np.linalg.norm(result.velocity[settled], axis=1)) < 0.35
    assert np.max(np.abs(np.degrees(result.attitude[settled]))) < 3.0


def test_large_gyro_bias_in_motion(town: Drive) -> None:
    """0.07 rad/s of gyro bias, as an uncalibrated phone has, is found within the alignment."""
    drive = part(town, 95.0, 140.0)
    drive.samples[:, :3] += (0.02, -0.04, 0.07)
    result = run(drive, CONFIG)
    k = result.at(135.0)
    true = town.truth.bias_g[1349] + (0.02, -0.04, 0.07)
    np.testing.assert_allclose(result.biases[k, :3], true, atol=1.0e-3)
    assert np.max(np.abs(degrees(result, 135.0))) < 2.0


def test_given_yaw_starts_at_rest(town: Drive) -> None:
    """With the yaw of the parking place known, navigation begins as soon as it is level and has a fix."""
    result = run(part(town, 0.0, 40.0), dataclasses.replace(CONFIG, initial_yaw=math.radians(62.0)))
    assert result.t[np.argmax(result.mode == NAVIGATING)] < 12.0
    assert np.max(np.abs(np.degrees(result.attitude[result.t > 12.0, 2]))) < 1.0


@pytest.mark.parametrize("error_deg", [30.0, 90.0, 180.0])
def test_wrong_yaw_is_found_and_mended(town: Drive, error_deg: float) -> None:
    """A given yaw that is wrong by more than 20° contradicts the course: alignment begins anew."""
    wrong = math.radians((62.0 + error_deg) % 360.0)
    result = run(part(town, 40.0, 160.0), dataclasses.replace(CONFIG, initial_yaw=wrong))
    assert abs(degrees(result, 78.0)[2]) > 25.0
    assert np.any(result.seen("realigned"))
    late = result.t > 125.0
    assert np.max(np.abs(np.degrees(result.attitude[late, 2]))) < 1.5
    assert np.max(result.horizontal[late]) < 5.0


REVERSING = """
segment = [
  { kind = "rest", duration_s = 20.0 },
  { kind = "reach-speed", duration_s = 6.0, to_mps = 9.0 },
  { kind = "turn", duration_s = 8.0, angle_deg = 80.0 },
  { kind = "reach-speed", duration_s = 6.0, to_mps = 0.0 },
  { kind = "rest", duration_s = 3.0 },
  { kind = "reach-speed", duration_s = 8.0, to_mps = -10.0 },
  { kind = "cruise", duration_s = 20.0 },
  { kind = "turn", duration_s = 8.0, angle_deg = 50.0 },
  { kind = "reach-speed", duration_s = 6.0, to_mps = 0.0 },
  { kind = "reach-speed", duration_s = 8.0, to_mps = 12.0 },
  { kind = "cruise", duration_s = 20.0 }]
[place]
latitude_deg = 30.0
longitude_deg = 114.0
height_m = 50.0
[initial]
yaw_deg = 62.0
[trajectory]
blend_s = 0.6
[imu]
preset = "bmi160"
"""


@pytest.mark.parametrize("velocity", ["3d", "2d"])
def test_reversing_fast_does_not_turn_the_heading(tmp_path: Path, velocity: str) -> None:
    """Half a minute backwards at 10 m/s, with a turn: the course is opposite to the nose, and yaw stays."""
    scenario = tmp_path / "reversing.toml"
    scenario.write_text(REVERSING)
    drive = make_drive(scenario, velocity=velocity)
    result = run(drive, CONFIG)
    assert not np.any(result.seen("realigned"))
    navigating = result.t > 40.0
    assert np.all(result.mode[navigating] == NAVIGATING)
    assert np.max(np.abs(np.degrees(result.attitude[navigating, 2]))) < 3.0
    assert np.max(result.horizontal[navigating]) < 5.0
    assert np.max(np.linalg.norm(result.velocity[navigating], axis=1)) < 0.4


def test_mounting_matrix_turns_the_chip(town: Drive) -> None:
    """A chip on its back and turned by 90°, with its C_b_s, gives the same solution as an aligned one."""
    C_b_s = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    straight = part(town, 0.0, 110.0)
    turned = part(town, 0.0, 110.0)
    turned.samples = np.hstack((straight.samples[:, :3] @ C_b_s, straight.samples[:, 3:] @ C_b_s))
    there = run(turned, dataclasses.replace(CONFIG, C_b_s=tuple(C_b_s.ravel().tolist())))
    here = run(straight, CONFIG)
    np.testing.assert_allclose(there.position, here.position, atol=1e-3)
    np.testing.assert_allclose(there.attitude, here.attitude, atol=1e-5)


def test_never_navigates_without_motion_or_yaw(town: Drive) -> None:
    """At rest without a given yaw the position shown is the fix, and yaw is told to be unknown."""
    result = run(part(town, 0.0, 60.0), CONFIG)
    assert NAVIGATING not in result.mode
    assert np.max(result.horizontal[result.t > 3.0]) < 8.0
    assert np.max(np.abs(result.velocity[result.t > 3.0])) < 0.3
