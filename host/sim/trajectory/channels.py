"""Speed, yaw, pitch and roll of the path at an instant, from the compiled pieces."""

from __future__ import annotations

from host.sim.compiled import Floats, Integers, inner
from host.sim.sine import sincos
from host.sim.trajectory.tables import FIRST, STARTS

CHANNELS = 4
SPEED, YAW, PITCH, ROLL = range(4)


@inner
def find_pieces(layout: Integers, t_ns: int, row: Integers) -> None:
    """Move the channels' current rows forward (or back) to the pieces that hold `t_ns`."""
    for channel in range(CHANNELS):
        k = row[channel]
        while k + 1 < layout[FIRST + channel + 1] and layout[STARTS + k + 1] <= t_ns:
            k += 1
        while k > layout[FIRST + channel] and layout[STARTS + k] > t_ns:
            k -= 1
        row[channel] = k


@inner
def channel(layout: Integers, c: Floats, k: int, t_ns: int) -> tuple[float, float, float]:
    """Value, first and second derivative of piece `k`."""
    tau = (t_ns - layout[STARTS + k]) * 1e-9
    x, d, e = c[k, 7], 0.0, 0.0
    for i in range(6, -1, -1):
        e = e * tau + d
        d = d * tau + x
        x = x * tau + c[k, i]
    if c[k, 20] == 0.0:
        return x, d, 2.0 * e
    wave, wave1, wave2 = wave_part(c, k, tau)
    return x + wave, d + wave1, 2.0 * e + wave2


@inner
def wave_part(c: Floats, k: int, tau: float) -> tuple[float, float, float]:
    """The sine and cosine terms of piece `k` and their derivatives."""
    w = c[k, 20]
    s, s1, s2 = c[k, 13], 0.0, 0.0
    q, q1, q2 = c[k, 19], 0.0, 0.0
    for i in range(4, -1, -1):
        s2 = s2 * tau + s1
        s1 = s1 * tau + s
        s = s * tau + c[k, 8 + i]
        q2 = q2 * tau + q1
        q1 = q1 * tau + q
        q = q * tau + c[k, 14 + i]
    sin, cos = sincos(w * tau)
    return (
        s * sin + q * cos,
        (s1 - w * q) * sin + (q1 + w * s) * cos,
        (2.0 * s2 - 2.0 * w * q1 - w * w * s) * sin + (2.0 * q2 + 2.0 * w * s1 - w * w * q) * cos,
    )


@inner
def path_velocity(layout: Integers, c: Floats, row: Integers, t_ns: int) -> tuple[float, float, float]:
    """v_n of the path without vibration, for the integration of the position."""
    v, _, _ = channel(layout, c, row[SPEED], t_ns)
    yaw, _, _ = channel(layout, c, row[YAW], t_ns)
    pitch, _, _ = channel(layout, c, row[PITCH], t_ns)
    sy, cy = sincos(yaw)
    sp, cp = sincos(pitch)
    return v * cp * cy, v * cp * sy, -v * sp
