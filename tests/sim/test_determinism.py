"""One scenario and seed give one world, bit for bit, however it is asked and run; memory stays flat."""

import os
import subprocess
import sys
import tracemalloc
from pathlib import Path

import numpy as np
from drives import SCENARIOS
from state_digest import digest

from host.sim.scenario.load import load_scenario
from host.sim.world import World

SECOND = 1_000_000_000
ROUGH = str(SCENARIOS / "rough.toml")


def test_interpreted_and_compiled_give_the_same_bits():
    program = Path(__file__).with_name("state_digest.py")
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(Path(__file__).parents[2])}
    run = subprocess.run(
        [sys.executable, str(program), ROUGH], capture_output=True, text=True, env=environment, check=True
    )
    assert run.stdout.strip() == digest(ROUGH)


def test_two_worlds_are_equal_and_seeds_differ():
    assert digest(ROUGH) == digest(ROUGH)
    other = World(load_scenario(ROUGH), 6)
    one = World(load_scenario(ROUGH), 5)
    times = 90 * SECOND + np.arange(10) * 10_000_000
    assert not np.array_equal(other.imu("a").sample(times, 40.0), one.imu("a").sample(times, 40.0))


def test_truth_can_be_asked_at_any_time_in_any_order():
    forward, jumping = World(load_scenario(ROUGH), 1), World(load_scenario(ROUGH), 1)
    forward.imu("a"), jumping.imu("a")
    times = np.array([100, 400, 900, 1100]) * SECOND
    walked = [forward.truth(np.array([t])) for t in times]
    jumped = [jumping.truth(np.array([t])) for t in times[::-1]][::-1]
    for a, b in zip(walked, jumped, strict=True):
        assert (a.latitude, a.height, a.yaw) == (b.latitude, b.height, b.yaw)
        np.testing.assert_array_equal(a.bias_g, b.bias_g)
    again = jumping.truth(times)
    np.testing.assert_array_equal(again.latitude, [float(a.latitude[0]) for a in walked])


def test_ten_hours_need_no_more_memory_than_one():
    world = World(load_scenario(ROUGH, ["duration_s=36000.0"]), 1)
    sensor, receiver = world.imu("a"), world.gnss("b")
    block = np.arange(20) * 10_000_000

    def drive(start_s, end_s):
        for t in range(start_s, end_s, 30):
            sensor.sample(t * SECOND + block, 40.0)
            receiver.epoch(t * SECOND)
            world.truth(t * SECOND + block[:1])

    drive(0, 3600)
    tracemalloc.start()
    drive(3600, 7200)
    first, _ = tracemalloc.get_traced_memory()
    drive(7200, 14400)
    later, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert later - first < 200_000
