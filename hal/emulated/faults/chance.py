"""Randomness of a fault: its own generator, seeded by (seed, name), so that no other draw changes its own."""

from __future__ import annotations

import numpy as np

from hal.emulated.virtual_time import FAR


def generator(seed: int, name: str) -> np.random.Generator:
    """The generator of one fault."""
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, *name.encode()])))


class Strikes:
    """Which of a series of things are struck, each with the same probability."""

    def __init__(self, probability: float, seed: int, name: str) -> None:
        if not 0.0 <= probability <= 1.0:
            raise ValueError(f"probability {probability!r}; it must lie in 0 … 1, e.g. 1e-3")
        self._random = generator(seed, name)
        self._probability = probability
        self._spared = self._distance()

    def next(self) -> bool:
        """Whether the next one is struck."""
        if self._spared:
            self._spared -= 1
            return False
        self._spared = self._distance()
        return True

    def _distance(self) -> int:
        return int(self._random.geometric(self._probability)) - 1 if self._probability else FAR


class BitErrors:
    """Flips single bits with a probability each, by drawing the distance to the next error."""

    def __init__(self, probability: float, seed: int, name: str) -> None:
        if not 0.0 <= probability <= 1.0:
            raise ValueError(f"bit error probability {probability!r}; it must lie in 0 … 1, e.g. 1e-4")
        self._random = generator(seed, name)
        self._probability = probability
        self._good_bits = self._distance()

    def disturb(self, data: bytes) -> tuple[bytes, int]:
        """`data` with errors, and how many bits were flipped."""
        bits = 8 * len(data)
        if self._good_bits >= bits:
            self._good_bits -= bits
            return data, 0
        disturbed = bytearray(data)
        flipped = 0
        position = self._good_bits
        while position < bits:
            disturbed[position >> 3] ^= 0x80 >> (position & 7)
            flipped += 1
            position += 1 + self._distance()
        self._good_bits = position - bits
        return bytes(disturbed), flipped

    def _distance(self) -> int:
        return int(self._random.geometric(self._probability)) - 1 if self._probability else FAR
