"""Sway and vibration at an instant: sums of the bank's sinusoids and their size at a speed."""

from __future__ import annotations

from host.sim.compiled import Floats, Integers, inner
from host.sim.sine import sincos_turns
from host.sim.trajectory.tables import HALF_SPEED_SQUARED, LIMITS, SHAKE_ALWAYS

SWAY_ROLL, SWAY_PITCH, SWAY_YAW, SHIFT_X, SHIFT_Y, SHIFT_Z = range(6)
"""Targets, in the order of `host.sim.trajectory.disturbance.TARGETS`."""


@inner
def envelope(constants: Floats, v: float, v1: float, v2: float) -> tuple[float, float, float]:
    """Size of the shaking at a speed, and its derivatives with respect to time."""
    if constants[SHAKE_ALWAYS] != 0.0:
        return 1.0, 0.0, 0.0
    half = constants[HALF_SPEED_SQUARED]
    x = v * v
    r = 1.0 / (x + half)
    first = 2.0 * v * half * r * r
    second = 2.0 * half * (half - 3.0 * x) * r * r * r
    return x * r, first * v1, second * v1 * v1 + first * v2


@inner
def shaking(layout: Integers, bank: Floats, t_ns: int, waves: Floats, out: Floats) -> None:
    """Sums of the bank at `t_ns`: out (6, 3) = value and two derivatives per target; `waves` is scratch."""
    t = t_ns * 1e-9
    for i in range(bank.shape[1]):
        waves[0, i], waves[1, i] = sincos_turns(bank[0, i] * t + bank[1, i])
    for target in range(6):
        value, first, second = 0.0, 0.0, 0.0
        for i in range(layout[LIMITS + target], layout[LIMITS + target + 1]):
            value += bank[2, i] * waves[0, i]
            first += bank[3, i] * waves[1, i]
            second -= bank[4, i] * waves[0, i]
        out[target, 0] = value
        out[target, 1] = first
        out[target, 2] = second


@inner
def swell(out: Floats, e: float, e1: float, e2: float) -> None:
    """Multiply values and derivatives (6, 3) by the envelope."""
    for i in range(6):
        value, first = out[i, 0], out[i, 1]
        out[i, 2] = e2 * value + 2.0 * e1 * first + e * out[i, 2]
        out[i, 1] = e1 * value + e * first
        out[i, 0] = e * value
