"""Prints a digest of what a world gives, to compare compiled with interpreted runs.

Run as a program: python state_digest.py SCENARIO
"""

import hashlib
import sys

import numpy as np

from host.sim.scenario.load import load_scenario
from host.sim.world import World


def digest(path: str) -> str:
    world = World(load_scenario(path), seed=5)
    imu = world.imu("U2", np.diag([1.0, -1.0, -1.0]), np.array([0.4, -0.2, 0.1]))
    gnss = world.gnss("U3", np.array([-0.3, 0.1, -1.1]))
    hash_ = hashlib.sha256()
    for start in (34_000_000_000, 80_000_000_000, 128_500_000_000):
        times = start + np.arange(60) * 12_345_679
        hash_.update(imu.sample(times, 40.0).tobytes())
        hash_.update(world.truth(times[::20]).v_ned.tobytes())
        epoch = gnss.epoch(start)
        hash_.update(repr((epoch.latitude, epoch.longitude, epoch.height, epoch.velocity_ned)).encode())
    return hash_.hexdigest()


if __name__ == "__main__":
    print(digest(sys.argv[1]))
