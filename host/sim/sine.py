"""Sine and cosine by one branch-free polynomial: the same bits on every machine, and vectorised by LLVM.

Arguments are in turns. The fraction x ∈ [−½, ½] gives θ = πx ∈ [−π/2, π/2], where the Taylor series of
sin θ to θ²¹ and cos θ to θ²² are exact to rounding; then sin 2θ = 2 sin θ cos θ, cos 2θ = 1 − 2 sin² θ.
Absolute error below 3e-16 plus that of the argument.
"""

from __future__ import annotations

import math

from host.sim.compiled import inner

PI = math.pi
TWO_PI = 2.0 * math.pi
TURNS_PER_RADIAN = 0.5 / math.pi

_ROUND = 6755399441055744.0
"""1.5 · 2⁵²: adding and subtracting it rounds to the nearest integer."""

_S3, _S5, _S7, _S9, _S11 = (1.0 / math.factorial(k) for k in (3, 5, 7, 9, 11))
_S13, _S15, _S17, _S19, _S21 = (1.0 / math.factorial(k) for k in (13, 15, 17, 19, 21))
_C2, _C4, _C6, _C8, _C10 = (1.0 / math.factorial(k) for k in (2, 4, 6, 8, 10))
_C12, _C14, _C16, _C18, _C20 = (1.0 / math.factorial(k) for k in (12, 14, 16, 18, 20))
_C22 = 1.0 / math.factorial(22)


@inner
def sincos_turns(turns: float) -> tuple[float, float]:
    """(sin, cos) of an angle given in turns; |turns| < 2⁵⁰."""
    theta = PI * (turns - ((turns + _ROUND) - _ROUND))
    z = theta * theta
    s = _S17 - z * (_S19 - z * _S21)
    s = _S9 - z * (_S11 - z * (_S13 - z * (_S15 - z * s)))
    s = theta * (1.0 - z * (_S3 - z * (_S5 - z * (_S7 - z * s))))
    c = _C16 - z * (_C18 - z * (_C20 - z * _C22))
    c = _C8 - z * (_C10 - z * (_C12 - z * (_C14 - z * c)))
    c = 1.0 - z * (_C2 - z * (_C4 - z * (_C6 - z * c)))
    return 2.0 * s * c, 1.0 - 2.0 * s * s


@inner
def sincos(angle: float) -> tuple[float, float]:
    """(sin, cos) of an angle in radians."""
    return sincos_turns(angle * TURNS_PER_RADIAN)
