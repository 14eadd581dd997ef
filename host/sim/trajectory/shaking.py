"""Sway and vibration: sums of the bank's sinusoids, at many instants (lanes) at once, and their size at a
speed."""

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
def shaking(layout: Integers, bank: Floats, times: Floats, sums: Floats, out: Floats) -> None:
    """Sums of the bank at times (n) in s: out (6, 3, n) = value and two derivatives per target; `sums`
    (3, n) is scratch.

    Array assignments would make numba compile its words for arrays that do not fit, which takes 4 s.
    """
    for target in range(6):
        for k in range(3):
            for j in range(times.shape[0]):
                sums[k, j] = 0.0
        for i in range(layout[LIMITS + target], layout[LIMITS + target + 1]):
            frequency, phase = bank[0, i], bank[1, i]
            amplitude, by_w, by_w2 = bank[2, i], bank[3, i], bank[4, i]
            for j in range(times.shape[0]):
                sin, cos = sincos_turns(frequency * times[j] + phase)
                sums[0, j] += amplitude * sin
                sums[1, j] += by_w * cos
                sums[2, j] -= by_w2 * sin
        for k in range(3):
            for j in range(times.shape[0]):
                out[target, k, j] = sums[k, j]


@inner
def swell(out: Floats, j: int, e: float, e1: float, e2: float) -> None:
    """Multiply values and derivatives of lane `j`, out (6, 3, n), by the envelope."""
    for i in range(6):
        value, first = out[i, 0, j], out[i, 1, j]
        out[i, 2, j] = e2 * value + 2.0 * e1 * first + e * out[i, 2, j]
        out[i, 1, j] = e1 * value + e * first
        out[i, 0, j] = e * value
