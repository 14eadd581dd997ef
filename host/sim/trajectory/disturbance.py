"""Sway, vibration and coning on top of the driven path, as sums of sinusoids with analytic derivatives.

Band-limited noise is a seeded sum of sinusoids: the band is cut into equal cells, each holds one frequency
drawn in it and a drawn phase; equal amplitudes A = σ √(2/n) give the wanted RMS. Everything scales with
e(v) = v² / (v² + v₀²), so that a standing vehicle is at rest, unless it is told to shake always.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from host.sim.seeding import generator

TARGETS = ("roll", "pitch", "yaw", "shift_x", "shift_y", "shift_z")


@dataclass(frozen=True)
class Sinusoid:
    """amplitude · sin(2π (frequency t + phase)) added to a target: rad for angles, m for shifts along
    the path's axes."""

    target: str
    amplitude: float
    frequency_hz: float
    phase_turns: float


@dataclass(frozen=True)
class Coning:
    """The body axis z goes round a cone of half-angle `half_angle` rad, `frequency_hz` times a second."""

    half_angle: float = 0.0
    frequency_hz: float = 1.0


@dataclass(frozen=True)
class Disturbance:
    """All that shakes the vehicle."""

    sinusoids: tuple[Sinusoid, ...] = ()
    coning: Coning = Coning()
    half_speed_mps: float = 2.0
    """v₀: at this speed the shaking has half its full size."""
    always: bool = False

    def bank(self) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Frequency, phase, amplitude and amplitude times ω and ω² (5, n), sorted by target, and the range
        limits (7,) of the targets."""
        ordered = [s for target in TARGETS for s in self.sinusoids if s.target == target]
        limits = [sum(TARGETS.index(s.target) < k for s in ordered) for k in range(len(TARGETS) + 1)]
        rows = np.zeros((5, len(ordered)))
        for i, s in enumerate(ordered):
            w = 2.0 * math.pi * s.frequency_hz
            rows[:, i] = s.frequency_hz, s.phase_turns, s.amplitude, s.amplitude * w, s.amplitude * w * w
        return rows, np.array(limits, dtype=np.int64)


def angle_band(
    target: str, rms: float, low_hz: float, high_hz: float, count: int, seed: int
) -> list[Sinusoid]:
    """Band-limited angle noise of `rms` rad."""
    amplitude = rms * math.sqrt(2.0 / count)
    return [Sinusoid(target, amplitude, f, p) for f, p in _draws(target, low_hz, high_hz, count, seed)]


def acceleration_band(
    target: str, rms: float, low_hz: float, high_hz: float, count: int, seed: int
) -> list[Sinusoid]:
    """Vibration of a shift target whose acceleration has `rms` m/s², flat over the band."""
    amplitude = rms * math.sqrt(2.0 / count)
    return [
        Sinusoid(target, amplitude / (2.0 * math.pi * f) ** 2, f, p)
        for f, p in _draws(target, low_hz, high_hz, count, seed)
    ]


def _draws(
    target: str, low_hz: float, high_hz: float, count: int, seed: int
) -> Sequence[tuple[float, float]]:
    random = generator(seed, f"shaking.{target}.{low_hz:g}-{high_hz:g}")
    cell = (high_hz - low_hz) / count
    frequencies = low_hz + cell * (np.arange(count) + random.random(count))
    return [(float(f), float(p)) for f, p in zip(frequencies, random.random(count), strict=True)]
