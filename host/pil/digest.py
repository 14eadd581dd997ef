"""The running digest of arrays and results as the image computes it (firmware/target/arrays.c).

h := h · M + word over 32-bit words, modulo 2⁶⁴, M odd: one changed word always changes it. All NaN count as
one, as x86 and ARM give them other signs and payloads.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

MULTIPLIER = 0x9E3779B97F4A7C15
MASK = (1 << 64) - 1
NAN = np.uint32(0x7FC00000)
INFINITY = np.uint32(0x7F800000)
WITHOUT_SIGN = np.uint32(0x7FFFFFFF)


def words_of(array: NDArray[Any]) -> NDArray[np.uint32]:
    """The words of an array, zeros behind an odd size, NaN made one."""
    missing = -array.nbytes % 4
    if missing:
        return np.frombuffer(array.tobytes() + bytes(missing), np.uint32)
    words = array.view(np.uint32)
    if array.dtype == np.float32:
        nan = (words & WITHOUT_SIGN) > INFINITY
        if nan.any():
            words = np.where(nan, NAN, words)
    return words


def digest_of(kernel: int, arrays: Iterable[NDArray[Any]], slots: Iterable[int]) -> int:
    """The digest after a call of `kernel` that left `arrays`; `slots`: its status and results."""
    digest = kernel
    for array in arrays:
        words = words_of(array)
        powers, whole = _powers(words.size)
        digest = (digest * whole + int(np.dot(words.astype(np.uint64), powers))) & MASK
    for slot in slots:
        for word in (slot & 0xFFFFFFFF, slot >> 32):
            digest = (digest * MULTIPLIER + word) & MASK
    return digest


@functools.cache
def _powers(size: int) -> tuple[NDArray[np.uint64], int]:
    """M to the power of n-1 … 0, and of n."""
    powers = [1]
    for _ in range(size):
        powers.append(powers[-1] * MULTIPLIER & MASK)
    return np.array(powers[-2::-1], np.uint64), powers[-1]
