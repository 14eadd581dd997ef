"""A vehicle at rest with chosen sensor errors."""

import numpy as np

from host.sim.scenario.load import scenario_from
from host.sim.world import World

SECOND = 1_000_000_000
PLACE = {"latitude_deg": 30.5, "longitude_deg": 114.3, "height_m": 20.0, "geoid_separation_m": -13.5}


def world(seed=1, **tables):
    data = {
        "place": PLACE,
        "duration_s": 36_000.0,
        "segment": [{"kind": "rest", "duration_s": 36_000.0}],
        "imu": {"preset": "perfect"},
        **tables,
    }
    return World(scenario_from(data, "standing", "test"), seed)


def sampled(sensor, rate_hz, seconds, bandwidth_hz=None, start_s=0.0):
    times = round(start_s * SECOND) + np.arange(round(rate_hz * seconds)) * SECOND // rate_hz
    return sensor.sample(times.astype(np.int64), bandwidth_hz or rate_hz / 2)
