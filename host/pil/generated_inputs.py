"""Inputs of a kernel made from its signature: ordinary, extreme, subnormal, huge, zero, infinite and NaN.

Where a kernel needs a sensible state (an index into its own ring, a mode), its owner gives the inputs: a file
`dialect_inputs.py` in any folder of tests, with

    INPUTS = {"firmware.nav.strapdown.imu_step": make_inputs}     # make_inputs(rng) -> tuple of arguments

Arrays must have the length that the firmware gives them. `make_inputs` is called several times with a NumPy
generator; scalars may be Python numbers.
"""

import importlib.util
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware.numerics.signature import Argument, Signature

TRIALS = 16
SEED = 20_240
INPUT_FILE = "dialect_inputs.py"

SUBNORMALS = np.array([1e-45, -1e-45, 1e-40, -1.1754942e-38], np.float32)
EDGES = np.array(
    [0.0, -0.0, 1.0, -1.0, 0.5, 1.5, 2.5, 1.1754944e-38, 3.4028235e38, -3.4028235e38, 16777216.0, 1e-7],
    np.float32,
)
NOT_FINITE = np.array([np.inf, -np.inf, np.nan], np.float32)
SMALLEST_LENGTH = 64
LARGEST_LENGTH = 16_384

Rng = np.random.Generator
MakeInputs = Callable[[Rng], tuple[Any, ...]]


def rng_of(kernel: str) -> Rng:
    """The same numbers for a kernel whatever other kernels exist."""
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence([SEED, zlib.crc32(kernel.encode())])))


def owners_inputs(tests: Path) -> dict[str, MakeInputs]:
    """All INPUTS in the files `dialect_inputs.py` below `tests`."""
    inputs: dict[str, MakeInputs] = {}
    for path in sorted(tests.rglob(INPUT_FILE)):
        specification = importlib.util.spec_from_file_location(f"dialect_inputs_{path.parent.name}", path)
        assert specification is not None
        assert specification.loader is not None
        module = importlib.util.module_from_spec(specification)
        specification.loader.exec_module(module)
        inputs.update(module.INPUTS)
    return inputs


def generated_inputs(signature: Signature, rng: Rng, length: int) -> Iterator[tuple[Any, ...]]:
    """TRIALS tuples of arguments; each trial draws from another kind of numbers, arrays have `length`."""
    for trial in range(TRIALS):
        yield tuple(_argument(argument, trial, rng, length) for argument in signature.arguments)


def _argument(argument: Argument, trial: int, rng: Rng, length: int) -> Any:
    size = length if argument.is_array else 1
    if argument.scalar == "boolean":
        values: NDArray[Any] = rng.integers(0, 2, size).astype(np.bool_)
    elif argument.scalar.startswith("float"):
        values = _floats(trial, rng, size).astype(argument.scalar)
    else:
        values = _integers(trial, rng, size, np.dtype(argument.scalar))
    return values if argument.is_array else values[0]


def _floats(trial: int, rng: Rng, size: int) -> NDArray[np.float32]:
    kind = trial % 8
    ordinary = rng.normal(0.0, 1.0, size).astype(np.float32)
    if kind == 0:
        return np.zeros(size, np.float32)
    if kind in (1, 2):
        return ordinary
    if kind == 3:
        return ordinary * np.float32(10.0) ** rng.integers(-6, 7, size).astype(np.float32)
    if kind == 4:
        return rng.choice(EDGES, size)
    if kind == 5:
        return rng.choice(np.concatenate([SUBNORMALS, EDGES]), size)
    if kind == 6:
        return rng.integers(0, 2**32, size, dtype=np.uint32).view(np.float32)
    ordinary[rng.integers(0, size, 1 + size // 8)] = rng.choice(NOT_FINITE)
    return ordinary


def _integers(trial: int, rng: Rng, size: int, dtype: np.dtype[Any]) -> NDArray[Any]:
    kind = trial % 4
    limits = np.iinfo(dtype)
    if kind == 0:
        return np.zeros(size, dtype)
    if kind == 1:
        return rng.integers(0, 8, size).astype(dtype)
    if kind == 2:
        return rng.integers(max(limits.min, -(2**20)), min(limits.max, 2**20), size, dtype=np.int64).astype(
            dtype
        )
    largest = min(int(limits.max), 2**40)
    smallest = max(int(limits.min), -(2**40))
    edges = np.array([0, 1, largest, largest - 1, smallest, smallest + 1, 2**7 - 1, 10], object)
    return rng.choice(edges, size).astype(dtype)
