"""How fast samples come, with truth and all errors: processor time of one core, the best of a few."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path

from host.sim.scenario.load import load_scenario
from host.simulate.formats.known import FORMATS
from host.simulate.job import simulate
from host.simulate.proof.figure import Figure
from host.simulate.proof.scenes import CAR
from host.simulate.stream import Drive, Request, warm_up

REPEATS = 5
OTHERS = 32_500.0
"""gnss-ins-sim, samples a second: path, inertial sensor, receiver and magnetometer."""
SMOOTH = [*(f"vibration.{axis}_mps2=0.0" for axis in "xyz"), "sway.roll_deg=0.0", "sway.pitch_deg=0.0"]


def figures() -> Iterator[Figure]:
    """Generation alone, with NPZ, and gnss-ins-sim's mix: 100 Hz, receiver 10 Hz, magnetometer 100 Hz."""
    car = load_scenario(CAR, SMOOTH)
    plain = Request(car)
    mix = Request(car, rate_hz=Fraction(100), gnss_rate_hz=Fraction(10), magnetometer_hz=Fraction(100))
    yield Figure("speed", "200 Hz car, unwritten", "1/s", _rate(plain), least=2e6)
    yield Figure("speed", "200 Hz car, NPZ", "1/s", _rate(plain, written=True), least=1e6)
    yield Figure(
        "speed", "path, IMU, receiver, magnetometer", "1/s", _rate(mix), "gnss-ins-sim: 32,500", 10.0 * OTHERS
    )


def _rate(request: Request, written: bool = False) -> float:
    warm_up(request)
    return max(_once(request, written) for _ in range(REPEATS))


def _once(request: Request, written: bool) -> float:
    drive = Drive(request)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "drive.npz" if written else None
        begin = time.process_time()
        simulate(drive, path, FORMATS["npz"] if written else None, {}, None)
        taken = time.process_time() - begin
        assert path is None or os.path.getsize(path) > 0
    return drive.samples / taken
