"""Inputs of the attitude computer's kernels for the gate: states met on short rides, samples good and bad.

Every ride turns, climbs and shakes as a small aircraft does, by any of the updates, in alignment or after it;
the compiled kernels make the states, the gate takes single steps from them both ways.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware.nav.attitude import layout as at
from firmware.nav.attitude.config import AttitudeConfig
from firmware.nav.attitude.flags import METHOD_NAMES
from firmware.nav.attitude.profiles import AttitudeLoop, load_loop

Rng = np.random.Generator
State = tuple[NDArray[Any], NDArray[np.int64]]


def burst(rng: Rng) -> NDArray[np.int64]:
    """One burst: of a rest, a flight, a saturated turn, or of no chip; some with words in wrong places."""
    kind = rng.integers(0, 8)
    counts = np.zeros(14, np.int64)
    counts[0] = 2068
    counts[1:4] = rng.integers(-6100, 6100, 3) if kind < 4 else rng.integers(-40, 40, 3)
    counts[4:7] = rng.integers(-8192, 8192, 3) if kind < 2 else (3, -5, -300)
    counts[7:10] = rng.integers(-600, 600, 3) if kind < 6 else 0
    counts[10] = 12_500
    words = (counts & 0x3FFF) | rng.choice([0x8000, 0x8000, 0xC000, 0])
    if kind == 7:
        words = np.full(14, rng.choice([0, 0xFFFF]), np.int64)
    return np.roll(words, 1) if rng.integers(0, 10) == 0 else words


def ride(rng: Rng, loop: AttitudeLoop) -> State:
    """The state after up to a second; up to three samples wait for the next iteration."""
    aligned = rng.integers(0, 4) > 0
    angles = tuple(float(angle) for angle in rng.uniform(-1.5, 1.5, 3))
    config = AttitudeConfig(
        latitude=float(rng.uniform(-1.57, 1.57)),
        longitude=float(rng.uniform(-math.pi, math.pi)),
        height=float(rng.uniform(-500.0, 9_000.0)),
        method=METHOD_NAMES[rng.integers(0, len(METHOD_NAMES))],
        attitude=angles if aligned else None,
        velocity=(20.0, -5.0, 1.0),
        alignment_time=0.04,
        null_gyros=bool(rng.integers(0, 2)),
        declination=0.05,
    )
    s, i, _ = loop.new_state(config)
    rest = np.array([2068, 3, -4, 5, 2, -3, -300, 400, 90, 800, 12_500, 0, 0, 0], np.int64) & 0x3FFF | 0x8000
    for _ in range(rng.integers(0, 120)):
        loop.take_words(s, i, burst(rng) if aligned else rest)
        if rng.integers(0, 8) > 0:
            loop.iterate(s, i)
    return s, i


def sample(rng: Rng, loop: AttitudeLoop) -> NDArray[Any]:
    """ω, f and m of any attitude and turn that the sensor could measure, and some beyond."""
    scale = np.repeat([6.0, 150.0, 6e-5], 3) * rng.choice([0.01, 1.0, 4.0])
    return loop.samples(rng.normal(0.0, 1.0, 9) * scale)


def inputs_of(profile: str) -> dict[str, Callable[[Rng], tuple[Any, ...]]]:
    loop = load_loop(profile)
    module = "firmware.nav.attitude." + ("fixed.loop" if profile == "fixed" else "loop")
    return {
        f"{module}.take_words": lambda rng: (*ride(rng, loop), burst(rng)),
        f"{module}.take_rates": lambda rng: (*ride(rng, loop), sample(rng, loop)),
        f"{module}.bridge": lambda rng: ride(rng, loop),
        f"{module}.iterate": lambda rng: ready(rng, loop),
        f"{module}.solution": lambda rng: (*ride(rng, loop), np.zeros(at.OUT_SIZE, np.int64)),
    }


def ready(rng: Rng, loop: AttitudeLoop) -> State:
    """A state with the samples of an iteration, whatever they are."""
    s, i = ride(rng, loop)
    while i[at.MODE] != 0 and i[at.IN_RING] < 3:
        loop.take_words(s, i, burst(rng))
    return s, i


INPUTS = inputs_of("float32") | inputs_of("fixed")
