"""Many instants side by side: the part of the kinematics that goes through vector registers.

Each quantity has LANES neighbours in memory, and an inner loop without branches over them becomes vector
instructions, provided that the arrays are made in the function itself, where LLVM sees their strides: 0.22
µs for an instant of a drive on tarmac instead of 0.36 one instant after the other. The bits are the same.
"""

from __future__ import annotations

from host.sim.compiled import Floats, Integers, inner
from host.sim.sine import TURNS_PER_RADIAN, sincos_turns
from host.sim.trajectory import channels
from host.sim.trajectory.channels import channel, find_pieces
from host.sim.trajectory.shaking import SWAY_PITCH, SWAY_ROLL, SWAY_YAW, envelope, swell

LANES = 32

V, V1, V2, YAW, YAW1, YAW2, PITCH, PITCH1, PITCH2, ROLL, ROLL1, ROLL2 = range(12)
E, E1, E2, AN, AE, AD, RM, RN, G, PATH = range(12, 22)
"""Rows of `path` (PATH, LANES): speed and angles of the path without shaking and their derivatives; the
envelope of the shaking and its derivatives; v̇_n, the Earth's radii M and N plus height, gravity."""

PATH_YAW, PATH_PITCH, BODY_YAW, BODY_PITCH, BODY_ROLL, PLACE, ANGLES = range(7)
SIN, COS, ANGLE = range(3)
"""`angles` (3, ANGLES, LANES): sines, cosines and the angles in rad themselves. PLACE is the latitude."""


@inner
def follow_path(layout: Integers, c: Floats, row: Integers, t_ns: int, j: int, path: Floats) -> None:
    """Speed and angles of lane `j` at `t_ns`.

    `layout` and `c` are of the `MotionTables`, `row` the channels' current pieces.
    """
    find_pieces(layout, t_ns, row)
    path[V, j], path[V1, j], path[V2, j] = channel(layout, c, row[channels.SPEED], t_ns)
    path[YAW, j], path[YAW1, j], path[YAW2, j] = channel(layout, c, row[channels.YAW], t_ns)
    path[PITCH, j], path[PITCH1, j], path[PITCH2, j] = channel(layout, c, row[channels.PITCH], t_ns)
    path[ROLL, j], path[ROLL1, j], path[ROLL2, j] = channel(layout, c, row[channels.ROLL], t_ns)


@inner
def shake_path(constants: Floats, path: Floats, shake: Floats, angles: Floats) -> None:
    """The shaking at the path's speed, and the angles whose sines are wanted."""
    for j in range(LANES):
        e, e1, e2 = envelope(constants, path[V, j], path[V1, j], path[V2, j])
        swell(shake, j, e, e1, e2)
        path[E, j], path[E1, j], path[E2, j] = e, e1, e2
        angles[ANGLE, PATH_YAW, j] = path[YAW, j]
        angles[ANGLE, PATH_PITCH, j] = path[PITCH, j]
        angles[ANGLE, BODY_YAW, j] = path[YAW, j] + shake[SWAY_YAW, 0, j]
        angles[ANGLE, BODY_PITCH, j] = path[PITCH, j] + shake[SWAY_PITCH, 0, j]
        angles[ANGLE, BODY_ROLL, j] = path[ROLL, j] + shake[SWAY_ROLL, 0, j]


@inner
def fill_sines(angles: Floats) -> None:
    """Sines and cosines of all angles."""
    for k in range(ANGLES):
        for j in range(LANES):
            sin, cos = sincos_turns(angles[ANGLE, k, j] * TURNS_PER_RADIAN)
            angles[SIN, k, j] = sin
            angles[COS, k, j] = cos
