"""What the second antenna is worth: heading with and without it, at rest and on the road; the receiver's own.

The same board in the same world runs with profile `float64` and with `no-attitude`. The receiver's own
heading is what its world tells at its epochs: the antennas sit along the forward axis, so the heading of the
baseline is the body's.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boards.description import Chip, load_board
from hal.emulated.virtual_time import SECOND
from host.record.errors import UserError
from host.record.result import RunRequest, RunResult
from host.run.readiness import prepared
from host.run.runner import run

BOARD = "dual_antenna"
PROFILES = {"on": "float64", "off": "no-attitude"}
SCENARIOS = {"at rest": "static", "on the road": "road"}
AFTER_S = 60.0
"""Behind the beginning of navigation."""
HEADING_LIMIT_DEG = 0.08
COMPASS = re.compile(r"gyro-compass: (\S+) deg, 1 sigma (\S+) deg after (\d+) s")


@dataclass(frozen=True, slots=True)
class HeadingRow:
    """One motion, with the second antenna or without; angles in degrees."""

    motion: str
    attitude: str
    """ "on" or "off"."""
    heading_rms: float
    heading_max: float
    pitch_rms: float
    receiver_rms: float
    begins_s: float
    """When navigation began."""

    @property
    def met(self) -> bool | None:
        """With the antenna: within the limit and better than the receiver. None: nothing is asked."""
        if self.attitude == "off":
            return None
        return self.heading_rms <= min(HEADING_LIMIT_DEG, self.receiver_rms)


@dataclass(frozen=True, slots=True)
class CompassRow:
    """What the gyro-compass told as it gathered; degrees, and its error against the truth."""

    after_s: int
    error: float
    sigma: float


def heading_rows(seed: int) -> Iterator[tuple[HeadingRow, list[CompassRow]]]:
    """All rows; with each what the gyro-compass told in that run."""
    for motion, scenario in SCENARIOS.items():
        receiver_rms = receiver_heading_rms(scenario, seed)
        for attitude, profile in PROFILES.items():
            result = run(RunRequest(BOARD, scenario, profile=profile, seed=seed, capture=False))
            yield _row(motion, attitude, result, receiver_rms), _compass(result, scenario, seed)


def _row(motion: str, attitude: str, result: RunResult, receiver_rms: float) -> HeadingRow:
    assert result.data is not None
    series = result.data.solution
    times_s = series.column("t_s")
    begins_s = result.metrics["aligned_at_s"]
    if begins_s is None:
        raise UserError(f"the board did not begin to navigate {motion}, second antenna {attitude}")
    late = times_s >= begins_s + AFTER_S
    yaw = np.abs(series.column("error_yaw_deg")[late])
    pitch = series.column("error_pitch_deg")[late]
    return HeadingRow(motion, attitude, _rms(yaw), float(yaw.max()), _rms(pitch), receiver_rms, begins_s)


def _rms(values: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _compass(result: RunResult, scenario: str, seed: int) -> list[CompassRow]:
    """From the words of the board."""
    _, world = prepared(RunRequest(BOARD, scenario, seed=seed))
    rows = []
    for event in result.events:
        found = COMPASS.fullmatch(event.text)
        if found is not None:
            truth = world.truth(np.array([round(event.at_s * SECOND)]))
            off = float(found[1]) - float(np.degrees(truth.yaw[0]))
            rows.append(CompassRow(int(found[3]), (off + 180.0) % 360.0 - 180.0, float(found[2])))
    return rows


def receiver_heading_rms(scenario: str, seed: int) -> float:
    """Of the receiver's own heading over the whole scenario, degrees."""
    _, world = prepared(RunRequest(BOARD, scenario, seed=seed))
    refdes, chip = _receiver()
    second = np.array(chip.second_antenna_m)
    receiver = world.gnss(refdes, np.array(chip.lever_arm_m), second)
    times_ns = np.arange(SECOND, world.duration_ns, SECOND)
    truth = world.another().truth(times_ns)
    told = [receiver.epoch(int(time_ns)).baseline for time_ns in times_ns]
    off = [
        (one.heading - yaw + np.pi) % (2.0 * np.pi) - np.pi
        for one, yaw in zip(told, truth.yaw, strict=True)
        if one is not None and one.fix == "FIXED"
    ]
    return float(np.degrees(_rms(np.array(off))))


def _receiver() -> tuple[str, Chip]:
    chips = load_board(BOARD).chips.items()
    return next((refdes, chip) for refdes, chip in chips if chip.second_antenna_m is not None)
