"""A ride interpreted by CPython, without numba, ends in the same bits as the compiled one."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from attitude_rig import FLIGHT_BEGIN, LATITUDE, LONGITUDE, Ride, bursts, flight

from firmware.nav.attitude.config import AttitudeConfig
from firmware.nav.attitude.flags import METHOD_NAMES

HERE = Path(__file__).resolve().parent
PROGRAM = "import test_attitude_interpreted as t; print(t.json.dumps(t.ends()))"


def ends():
    """State and record after an alignment and some iterations, by every update, in hexadecimal."""
    words = bursts(flight(0.25, noise=True))
    found = {}
    for profile in ("float32", "fixed"):
        for method in METHOD_NAMES:
            begin = FLIGHT_BEGIN if method != "rk4" else None
            config = AttitudeConfig(
                latitude=LATITUDE, longitude=LONGITUDE, attitude=begin, method=method, alignment_time=0.04
            )
            ride = Ride(profile, config).drive_words(words)
            state = (ride.s, ride.i, ride.record())
            found[f"{profile} {method}"] = [part.tobytes().hex() for part in state]
    return found


@pytest.fixture(scope="module")
def interpreted():
    environment = dict(
        os.environ, NUMBA_DISABLE_JIT="1", PYTHONPATH=os.pathsep.join([str(HERE.parents[1]), str(HERE)])
    )
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM], env=environment, capture_output=True, text=True, check=True
    )
    return json.loads(done.stdout)


def test_interpreted_ride_ends_in_the_same_bits(interpreted):
    compiled = ends()
    assert interpreted.keys() == compiled.keys()
    assert [name for name in compiled if compiled[name] != interpreted[name]] == []
