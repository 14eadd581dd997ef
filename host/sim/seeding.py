"""Randomness by name: every channel of every component has a generator of its own.

Adding a sensor changes no other sensor's noise, and two runs with one seed are equal.
"""

from __future__ import annotations

import numpy as np


def generator(seed: int, name: str, part: int | None = None) -> np.random.Generator:
    """The generator of the channel `name`; `part` numbers independent stretches of one channel."""
    words = [seed, *name.encode()]
    if part is not None:
        words += [part]
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(words)))
