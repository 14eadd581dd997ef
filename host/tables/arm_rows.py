"""What longer arms are worth with real accelerometers: the rate alone, and the board on a drive with losses.

The rate alone: the fused method over a minute from rest, noise and clocks of ADXL345, no filter behind it.
The board: scenario `losses`, profile `adxl345`, with its arms as long as asked; ten seconds without compass,
sixty without GPS.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from host.record.errors import UserError
from host.record.result import RunRequest
from host.run.runner import run
from host.tables.rate_methods import rate_row
from host.tables.rate_motion import ROTATIONS, SENSORS

BOARD, SCENARIO, PROFILE = "gfsins", "losses", "adxl345"
SETTLED_S, COMPASS_LOST_S, COMPASS_BACK_S = 40.0, 100.0, 112.0
"""When the filters have settled; when the compass falls silent, and is heard again."""
ONE_AXIS, ALL_AXES = ROTATIONS[2], ROTATIONS[3]
RATE_SECONDS, RATE_SEEDS = 60.0, (1, 2, 3)


@dataclass(frozen=True, slots=True)
class ArmRow:
    """One length of the arms."""

    arm_m: float
    rate_one_axis: float
    """RMS over a minute, rad/s, turning about one axis; then about all."""
    rate_all_axes: float
    tilt_deg: float
    """RMS of roll and pitch together, with compass and GPS."""
    heading_deg: float
    heading_without_compass_deg: float
    """Largest error within ten seconds."""
    position_m: float
    """Horizontal RMS with GPS."""
    drift_m: float
    """Horizontal error after sixty seconds without."""
    velocity_without_gps_mps: float
    """Largest horizontal error then."""


def arm_rows(arms: Sequence[float], seed: int) -> Iterator[ArmRow]:
    """One row a length."""
    for arm in arms:
        yield arm_row(arm, seed)


def arm_row(arm: float, seed: int) -> ArmRow:
    """Raises UserError when the board does not navigate."""
    asked = RunRequest(
        BOARD,
        SCENARIO,
        profile=PROFILE,
        seed=seed,
        capture=False,
        overrides=(f"board.arm_length_m={arm!r}", "expect={}"),
    )
    result = run(asked)
    assert result.data is not None
    series = result.data.solution
    times = series.column("t_s")
    with_both = (times > SETTLED_S) & (times < COMPASS_LOST_S)
    without_compass = (times > COMPASS_LOST_S) & (times < COMPASS_BACK_S)
    outage = result.outages[0]
    without_gps = (times > outage.start_s) & (times < outage.start_s + outage.duration_s)
    if not with_both.any() or outage.horizontal_drift_m is None:
        raise UserError(f"with arms of {arm:g} m the board did not navigate")

    def lengths(names: str, chosen: NDArray[np.bool_]) -> NDArray[np.float64]:
        return np.hypot(*(series.column(name)[chosen] for name in names.split()))

    heading = np.abs(series.column("error_yaw_deg"))
    noisy = SENSORS[-1]
    one_axis, all_axes = (
        rate_row(rotation, noisy, arm, RATE_SECONDS, RATE_SEEDS).error["fused"]
        for rotation in (ONE_AXIS, ALL_AXES)
    )
    return ArmRow(
        arm,
        one_axis,
        all_axes,
        _rms(lengths("error_roll_deg error_pitch_deg", with_both)),
        _rms(heading[with_both]),
        float(np.max(heading[without_compass])),
        _rms(lengths("error_north_m error_east_m", with_both)),
        outage.horizontal_drift_m,
        float(np.max(lengths("error_v_north_mps error_v_east_mps", without_gps))),
    )


def _rms(values: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
