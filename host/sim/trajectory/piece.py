"""Pieces of motion: a polynomial plus polynomials times one sine and cosine.

    x(τ) = Σ p_k τ^k + Σ s_k τ^k sin ωτ + Σ c_k τ^k cos ωτ,   0 ≤ τ ≤ duration

The family is closed under integration and under multiplication by a polynomial window, so that rates of
every segment kind integrate exactly to speeds and angles, and all derivatives are exact.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

POLYNOMIAL_TERMS = 8
WAVE_TERMS = 6

SMOOTHSTEP = (0.0, 0.0, 0.0, 10.0, -15.0, 6.0)
"""10x³ − 15x⁴ + 6x⁵ rises from 0 to 1 with two zero derivatives at both ends."""


@dataclass(frozen=True, slots=True)
class Piece:
    """One piece; coefficients from the constant term up, `omega` in rad/s."""

    duration_s: float
    polynomial: tuple[float, ...]
    sine: tuple[float, ...] = ()
    cosine: tuple[float, ...] = ()
    omega: float = 0.0

    def value(self, tau: float) -> float:
        """x(τ)."""
        angle = self.omega * tau
        return (
            _horner(self.polynomial, tau)
            + _horner(self.sine, tau) * math.sin(angle)
            + _horner(self.cosine, tau) * math.cos(angle)
        )

    def bound(self) -> float:
        """What |x(τ)| nowhere exceeds; often a good deal more than it reaches."""
        sums = _horner(tuple(map(abs, self.polynomial)), self.duration_s)
        for coefficients in (self.sine, self.cosine):
            sums += _horner(tuple(map(abs, coefficients)), self.duration_s)
        return sums

    def integral(self, start_value: float) -> Piece:
        """The piece whose derivative this is and whose value at τ = 0 is `start_value`."""
        polynomial = [0.0] + [p / (k + 1) for k, p in enumerate(self.polynomial)]
        sine, cosine = self._integrated_waves()
        polynomial[0] = start_value - (cosine[0] if cosine else 0.0)
        return Piece(self.duration_s, tuple(polynomial), sine, cosine, self.omega)

    def derivative(self) -> Piece:
        """The piece that tells how fast this one changes."""
        polynomial = tuple((k + 1) * p for k, p in enumerate(self.polynomial[1:])) or (0.0,)
        terms = max(len(self.sine), len(self.cosine))
        s = [*self.sine, *[0.0] * (terms + 1 - len(self.sine))]
        c = [*self.cosine, *[0.0] * (terms + 1 - len(self.cosine))]
        sine = tuple((k + 1) * s[k + 1] - self.omega * c[k] for k in range(terms))
        cosine = tuple((k + 1) * c[k + 1] + self.omega * s[k] for k in range(terms))
        return Piece(self.duration_s, polynomial, sine, cosine, self.omega)

    def _integrated_waves(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """(A, B) with d/dτ (A sin ωτ + B cos ωτ) = s sin ωτ + c cos ωτ, from the highest power down."""
        terms = max(len(self.sine), len(self.cosine))
        if terms == 0:
            return (), ()
        s = [*self.sine, *[0.0] * (terms - len(self.sine))]
        c = [*self.cosine, *[0.0] * (terms - len(self.cosine))]
        a, b = [0.0] * (terms + 1), [0.0] * (terms + 1)
        for k in range(terms - 1, -1, -1):
            a[k] = (c[k] - (k + 1) * b[k + 1]) / self.omega
            b[k] = ((k + 1) * a[k + 1] - s[k]) / self.omega
        return tuple(a[:terms]), tuple(b[:terms])

    def times(self, window: tuple[float, ...]) -> Piece:
        """This piece multiplied by a polynomial in τ."""
        return Piece(
            self.duration_s,
            _product(self.polynomial, window),
            _product(self.sine, window),
            _product(self.cosine, window),
            self.omega,
        )

    def plus(self, polynomial: tuple[float, ...]) -> Piece:
        """This piece with a polynomial in τ added."""
        terms = max(len(self.polynomial), len(polynomial))
        padded = [*self.polynomial, *[0.0] * (terms - len(self.polynomial))]
        for k, p in enumerate(polynomial):
            padded[k] += p
        return Piece(self.duration_s, tuple(padded), self.sine, self.cosine, self.omega)

    def coefficients(self) -> list[float]:
        """A row of the compiled table: polynomial, sine, cosine, ω."""
        return [
            *_padded(self.polynomial, POLYNOMIAL_TERMS),
            *_padded(self.sine, WAVE_TERMS),
            *_padded(self.cosine, WAVE_TERMS),
            self.omega,
        ]


def constant(duration_s: float, value: float) -> Piece:
    """A piece that stays at `value`."""
    return Piece(duration_s, (value,))


def ramp(duration_s: float, start: float, end: float) -> Piece:
    """A straight line from `start` to `end`."""
    return Piece(duration_s, (start, (end - start) / duration_s))


def smooth_step(duration_s: float, start: float, end: float) -> Piece:
    """From `start` to `end` by the quintic, with zero first and second derivatives at both ends."""
    polynomial = [(end - start) * s / duration_s**k for k, s in enumerate(SMOOTHSTEP)]
    polynomial[0] += start
    return Piece(duration_s, tuple(polynomial))


def wave(duration_s: float, amplitude: float, period_s: float, phase: float) -> Piece:
    """amplitude · sin(2π τ / period + phase)."""
    sine, cosine = amplitude * math.cos(phase), amplitude * math.sin(phase)
    return Piece(duration_s, (0.0,), (sine,), (cosine,), 2.0 * math.pi / period_s)


def rise_window(width_s: float) -> tuple[float, ...]:
    """Polynomial in τ that goes smoothly from 0 to 1 over `width_s`."""
    return tuple(s / width_s**k for k, s in enumerate(SMOOTHSTEP))


def fall_window(width_s: float) -> tuple[float, ...]:
    """1 − rise."""
    rise = rise_window(width_s)
    return (1.0, *(-s for s in rise[1:]))


def _horner(coefficients: tuple[float, ...], x: float) -> float:
    total = 0.0
    for c in reversed(coefficients):
        total = total * x + c
    return total


def _product(a: tuple[float, ...], b: tuple[float, ...]) -> tuple[float, ...]:
    if not a or not b:
        return ()
    out = [0.0] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            out[i + j] += x * y
    return tuple(out)


def _padded(coefficients: tuple[float, ...], length: int) -> list[float]:
    extra = coefficients[length:]
    if any(extra):
        raise ValueError(f"piece has {len(coefficients)} coefficients, the table holds {length}")
    return [*coefficients[:length], *[0.0] * (length - len(coefficients))]
