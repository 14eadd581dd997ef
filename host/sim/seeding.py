"""Randomness by name: every channel of every component has a generator of its own.

Adding a sensor changes no other sensor's noise, and two runs with one seed are equal. Different seeds and
names never share a stream: the entropy of a generator is the seed as one 32-bit word followed by one word
for each byte of the name, and zero words, with which NumPy fills up short entropy, are in no name.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

ROWS_AT_ONCE = 64

LARGEST_SEED = 2**32 - 1
"""A larger one would take two words and could be read as a smaller seed with a longer name."""


def generator(seed: int, name: str) -> np.random.Generator:
    """The generator of the channel `name`. ValueError for a seed or name that could be taken for another."""
    if not 0 <= seed <= LARGEST_SEED:
        raise ValueError(f"seed {seed}; it must lie in 0 … {LARGEST_SEED}, for example 1")
    if not name or "\0" in name:
        raise ValueError(f"channel {name!r}; it must have a name without zero bytes, e.g. 'U2.gyro_x.noise'")
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, *name.encode()])))


class NormalRows:
    """Standard normals of several channels, a row at a time. Each channel has its own generator, from which
    many are drawn at once: one by one costs ten times as much."""

    def __init__(self, seed: int, names: Sequence[str]) -> None:
        self._generators = [generator(seed, name) for name in names]
        self._rows: list[list[float]] = []

    def next(self) -> list[float]:
        """One value of each channel."""
        if not self._rows:
            columns = [channel.standard_normal(ROWS_AT_ONCE) for channel in self._generators]
            self._rows = np.column_stack(columns)[::-1].tolist()
        return self._rows.pop()
