"""The whole intermediate code of a kernel and of all that it calls, optimised for no particular processor."""

from __future__ import annotations

import functools
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import llvmlite.binding as llvm
from numba.core.compiler_lock import global_compiler_lock

from firmware.numerics.dialect import compile_once_for_all_literals, declare_only
from firmware.numerics.inner_code import make_inner
from firmware.numerics.signature import Signature
from firmware.numerics.variants import KernelVariant

OPTIONS = {"error_model": "numpy", "boundscheck": False, "fastmath": False, "_nrt": False}
PLAIN_PROCESSOR = "x86-64"
"""What the code must run on here: the least of this family, so that nothing of a newer one shows."""


@dataclass(frozen=True, slots=True)
class WholeCode:
    """`module` defines `entry`, which takes a pointer for the result, one for an error, and the arguments."""

    module: Any
    entry: str
    signature: Signature


@functools.cache
def _pointer_kernels() -> KernelVariant:
    return KernelVariant("counted", _make)


def _make(function: Callable[..., Any], signature: Signature | None) -> Any:
    """Arrays are bare pointers, as on a target."""
    made = make_inner(function, OPTIONS)
    if signature is None:
        compile_once_for_all_literals(made)
    else:
        declare_only(made, re.sub(r"(\w+)\[::1\]", r"CPointer(\1)", signature.text))
    made.declared = signature
    return made


@functools.cache
def whole_code(module: str, kernel: str) -> WholeCode:
    """The kernel `kernel` of `module` ("firmware.nav.strapdown"), which must have a signature."""
    variant = _pointer_kernels()
    made = getattr(variant.load(module), kernel)
    made.compile_declared()
    compiled = next(iter(made.overloads.values()))
    entry = compiled.fndesc.mangled_name
    with global_compiler_lock:
        compiled.library._ensure_finalized()  # links what it calls
    return WholeCode(_optimised(str(compiled.library._final_module), entry), entry, made.declared)


def plain_machine() -> Any:
    """LLVM's description of what the code runs on; what runs code takes it over."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    target = llvm.Target.from_triple(llvm.get_process_triple())
    return target.create_target_machine(cpu=PLAIN_PROCESSOR, features="", opt=2, jit=True)


def _optimised(text: str, entry: str) -> Any:
    module = llvm.parse_assembly(text)
    for function in module.functions:
        if not function.is_declaration and function.name != entry:
            function.linkage = "internal"
    options = llvm.create_pipeline_tuning_options(speed_level=2)
    options.loop_unrolling = options.loop_vectorization = options.slp_vectorization = False
    builder = llvm.create_pass_builder(plain_machine(), options)
    builder.getModulePassManager().run(module, builder)
    return module
