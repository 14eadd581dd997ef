"""Decorators of the simulator's inner loops: float64, compiled by numba, the same bits when interpreted.

Compiled entries are kept between runs in the cache of the firmware's kernels, in a folder whose name is a
hash of all sources of the simulator as well, because numba itself does not see a change in a function that
is called from another file. With NUMBA_DISABLE_JIT=1 the functions run as plain Python.

Rules for the bodies, so that both ways and all machines give the same bits: + − × ÷ and sqrt only (sines
by `host.sim.sine`, never the C library's), no `**`, no division by zero, no fast-math.
"""

from __future__ import annotations

import functools
import hashlib
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import llvmlite.binding
import numba
import numpy as np
from numpy.typing import NDArray

from firmware.numerics.cache_folder import kernel_cache_folder
from firmware.numerics.dialect import INTERPRETED
from firmware.numerics.inner_code import KernelCompiler, let_kernels_call, make_inner

F = TypeVar("F", bound=Callable[..., Any])
Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

BOARDS = Path(__file__).parents[2] / "boards"
_OPTIONS: dict[str, Any] = {"error_model": "numpy", "boundscheck": False, "fastmath": False}
_OPTIONS |= {"no_cfunc_wrapper": True}


def inner(function: F) -> F:
    """A function for compiled functions to call; Python may call it too, its machine code is not kept."""
    if INTERPRETED:
        return function
    dispatcher = numba.njit(**_OPTIONS, pipeline_class=KernelCompiler)(function)
    let_kernels_call(dispatcher, lambda: make_inner(function, {"forceinline": True, **_OPTIONS}))
    return dispatcher


def entry(function: F) -> F:
    """A function called from Python; its machine code is kept between runs."""
    if INTERPRETED:
        return function
    folder = _cache_folder()
    config: Any = numba.config
    # Numba decides where code is kept when it decorates; others in this process keep their own place.
    before, config.CACHE_DIR = config.CACHE_DIR, str(folder)
    try:
        return numba.njit(cache=folder is not None, **_OPTIONS, pipeline_class=KernelCompiler)(function)
    finally:
        config.CACHE_DIR = before


def keep_code_of_chips() -> None:
    """Keep beside ours what chip models compile by numba itself (`cache=True`) from now on.

    Numba's own place would be among the sources. Who sets NUMBA_CACHE_DIR decides otherwise.
    """
    config: Any = numba.config
    folder = None if config.CACHE_DIR or INTERPRETED else _folder_for(BOARDS)
    if folder is not None:
        config.CACHE_DIR = str(folder)


@functools.cache
def _cache_folder() -> Path | None:
    return _folder_for(Path(__file__).parent)


def _folder_for(sources: Path) -> Path | None:
    digest = hashlib.sha256()
    for path in sorted(sources.rglob("*.py")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    processor = llvmlite.binding.get_host_cpu_name()
    versions = f"{sys.version} numba {numba.__version__} numpy {np.__version__} {processor}"
    return kernel_cache_folder(f"{versions} {sources.name} {digest.hexdigest()}")
