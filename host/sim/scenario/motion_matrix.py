"""Rows of the numeric trajectory matrix (source 002, table 3-1) as motion segments."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from host.sim.scenario.motion_schema import (
    Accelerate,
    AccelerationRamp,
    Circle,
    Cruise,
    ReachSpeed,
    SegmentModel,
    SpeedChange,
    Surge,
    Turn,
    TurnRateRamp,
    Weave,
)

NEEDED = {1.0: 2, 2.0: 3, 3.0: 3, 4.0: 3, 5.0: 4, 6.0: 4, 7.0: 4, 8.0: 3, 9.0: 4, 91.0: 4, 10.0: 4}
"""Columns up to the last one that a type reads."""


def segment_of_row(row: Sequence[float]) -> SegmentModel:
    """One row: type code, duration and two parameters; those that the type does not read may be left out.

    ValueError when the code is not known, a parameter lacks or a value is out of range.
    """
    code, duration, p, q = [float(x) for x in (*row, 0.0, 0.0)][:4]
    if len(row) < NEEDED.get(code, 0):
        raise ValueError(
            f"type {code:g} needs {NEEDED[code]} columns (type, duration and parameters); for example"
            " [7, 8, 0, 90] turns right by 90°"
        )
    match code:
        case 1.0:
            return Cruise(kind="cruise", duration_s=duration)
        case 2.0:
            return SpeedChange(kind="speed-change", duration_s=duration, by_mps=p)
        case 3.0:
            return ReachSpeed(kind="reach-speed", duration_s=duration, to_mps=p)
        case 4.0:
            return Accelerate(kind="accelerate", duration_s=duration, acceleration_mps2=p)
        case 5.0:
            return Surge(kind="surge", duration_s=duration, amplitude_mps2=p, period_s=q)
        case 6.0:
            return AccelerationRamp(kind="acceleration-ramp", duration_s=duration, from_mps2=p, to_mps2=q)
        case 7.0:
            return Turn(kind="turn", duration_s=duration, angle_deg=q)
        case 8.0:
            return Circle(kind="circle", duration_s=duration, rate_dps=p)
        case 9.0 | 91.0:
            kind: Literal["weave", "weave-cosine"] = "weave" if code == 9.0 else "weave-cosine"
            return Weave(kind=kind, duration_s=duration, period_s=p, amplitude_dps=q)
        case 10.0:
            return TurnRateRamp(kind="turn-rate-ramp", duration_s=duration, from_dps=p, to_dps=q)
    raise ValueError(
        f"type code {code:g} is not one of 1 … 10, 91; for example [7, 8, 0, 90] turns right by 90°"
    )
