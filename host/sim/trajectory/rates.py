"""Rate profiles of the segment kinds: acceleration in m/s² or turn rate in rad/s over one segment.

`exact_*` follow source 002, table 3-1 and eqs. 3-3 … 3-21, to the letter, with their steps at the joints.
`blended` puts quintic flanks at both ends of any profile and adds a multiple of the same window, so that
the integral over the segment (speed change, angle) stays exactly that of the profile without flanks:

    r(τ) = W(τ) (r₀(τ) + c),   c = ∫ r₀ (1 − W) dτ / ∫ W dτ

Its steepest flank bounds the jerk (or angular acceleration): |ṙ| ≤ 1.875 max|r₀ + c| / blend + max|ṙ₀|.
"""

from __future__ import annotations

import math

from host.sim.trajectory.piece import Piece, constant, fall_window, ramp, rise_window, wave

TRAPEZOID_SHARE = 0.25
"""t₁/t: share of a segment that each flank takes, source 002 eqs. 3-9 … 3-13 and figure 3.4."""


def trapezoid(duration_s: float, integral: float) -> list[Piece]:
    """Types 2 and 3: straight flanks over a quarter each, plateau between."""
    flank = TRAPEZOID_SHARE * duration_s
    top = integral / (duration_s - flank)
    return [
        ramp(flank, 0.0, top),
        constant(duration_s - 2.0 * flank, top),
        ramp(flank, top, 0.0),
    ]


def document_turn(duration_s: float, angle: float) -> list[Piece]:
    """Type 7: rate of five parabolic pieces, angular acceleration continuous (eqs. 3-9 … 3-13)."""
    flank = TRAPEZOID_SHARE * duration_s
    half = 0.5 * flank
    k = 4.0 * angle / (duration_s**3 * TRAPEZOID_SHARE**2 * (1.0 - TRAPEZOID_SHARE))
    top = 0.25 * k * flank * flank
    middle = 0.5 * top
    return [
        Piece(half, (0.0, 0.0, 0.5 * k)),
        Piece(half, (middle, k * half, -0.5 * k)),
        constant(duration_s - 2.0 * flank, top),
        Piece(half, (top, 0.0, -0.5 * k)),
        Piece(half, (middle, -k * half, 0.5 * k)),
    ]


def blended(profile: Piece, blend_s: float) -> list[Piece]:
    """`profile` with quintic flanks of `blend_s` (at most half of it each) and the same integral."""
    duration = profile.duration_s
    width = min(blend_s, 0.5 * duration)
    if width <= 0.0:
        return [profile]
    parts = [
        (_part(profile, 0.0, width), rise_window(width)),
        (_part(profile, width, duration - 2.0 * width), (1.0,)),
        (_part(profile, duration - width, width), fall_window(width)),
    ]
    windowed = sum(_total(part.times(window)) for part, window in parts)
    correction = (_total(profile) - windowed) / (duration - width)
    return [part.plus((correction,)).times(window) for part, window in parts if part.duration_s > 0.0]


def _part(profile: Piece, start_s: float, duration_s: float) -> Piece:
    """The stretch of a profile from `start_s` on, as a piece of its own (at most linear, or one wave)."""
    if profile.omega:
        amplitude = math.hypot(profile.sine[0], profile.cosine[0])
        phase = math.atan2(profile.cosine[0], profile.sine[0]) + profile.omega * start_s
        return wave(duration_s, amplitude, 2.0 * math.pi / profile.omega, phase)
    slope = profile.polynomial[1] if len(profile.polynomial) > 1 else 0.0
    return Piece(duration_s, (profile.polynomial[0] + slope * start_s, slope))


def _total(rate: Piece) -> float:
    return rate.integral(0.0).value(rate.duration_s)
