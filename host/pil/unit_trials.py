"""Every kernel of a board on its own, with random and extreme inputs, on twin and processor.

Subnormal, huge and infinite numbers, NaN, signed zeros, extreme integers; or, where a kernel wants a sensible
state, what its owner gives in a `dialect_inputs.py` of the tests. An input that the interpreted kernel cannot
bear (an index outside, a float that fits no integer) is no input.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

import firmware
from firmware.numerics.dialect import Kernel, registered_kernels
from firmware.numerics.variants import KernelVariant
from host.pil.board_kernels import target_kernel
from host.pil.generated_inputs import MakeInputs, owners_inputs
from host.pil.kernel_table import TargetKernel
from host.pil.lockstep import Lockstep
from host.pil.mirror import LARGEST_ARRAY
from host.pil.strict_run import interpret_strictly, strict_trials

TESTS = Path(firmware.__path__[0]).parent / "tests"
MOST_KERNELS = 255


def unit_kernels(entries: Iterable[TargetKernel]) -> list[TargetKernel]:
    """The entries and every kernel with a signature that they call, however far."""
    known = {id(kernel.function): kernel for kernel in registered_kernels()}
    by_name = {kernel.name: kernel for kernel in registered_kernels()}
    waiting = [by_name[entry.name] for entry in entries]
    found = {kernel.name: kernel for kernel in waiting}
    while waiting:
        for callee in _callees(waiting.pop(), known):
            if callee.name not in found:
                found[callee.name] = callee
                waiting.append(callee)
    declared = [found[name] for name in sorted(found) if found[name].signature is not None]
    return [target_kernel(number, kernel) for number, kernel in enumerate(declared[:MOST_KERNELS])]


def _callees(kernel: Kernel, known: dict[int, Kernel]) -> list[Kernel]:
    names = kernel.function.__code__.co_names
    values = [kernel.function.__globals__.get(name) for name in names]
    functions = [getattr(value, "py_func", None) for value in values]
    return [known[id(function)] for function in functions if id(function) in known]


def run_trials(lockstep: Lockstep, notice: Callable[[str], None]) -> dict[str, str]:
    """All trials of all kernels of the image. Returns the kernels left out, and why."""
    interpreted = KernelVariant("strict", interpret_strictly)
    compiled = {kernel.name: kernel.callable for kernel in registered_kernels()}
    owners = owners_inputs(TESTS) if TESTS.is_dir() else {}
    left_out: dict[str, str] = {}
    for kernel in lockstep.image.kernels:
        notice(f"  {kernel.name}")
        interpreted.load(kernel.name.rpartition(".")[0])
        run = interpreted.kernels[kernel.name]
        reason = _try(lockstep, kernel, run, compiled[kernel.name], owners.get(kernel.name))
        if reason:
            left_out[kernel.name] = reason
    lockstep.flush()
    return left_out


def _try(
    lockstep: Lockstep,
    kernel: TargetKernel,
    interpreted: Callable[..., Any],
    compiled: Callable[..., Any],
    inputs: MakeInputs | None,
) -> str | None:
    """Why the kernel is left out, or None."""
    try:
        trials = strict_trials(kernel.name, kernel.signature, interpreted, inputs)
    except Exception as error:
        return f"no inputs that it can bear: {type(error).__name__}: {error}"
    tried = 0
    for arguments, _ in trials:
        arrays = [one for one in arguments if isinstance(one, np.ndarray)]
        sizes = [one.nbytes for one in arrays]
        if sum(sizes) + 8 * len(sizes) > lockstep.memory or max(sizes, default=0) > LARGEST_ARRAY:
            continue
        lockstep.forget_arrays(sizes)
        lockstep.call(kernel, compiled, *arguments)
        tried += 1
    return None if tried else "its arrays are larger than the processor's memory"
