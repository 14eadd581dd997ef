"""Kernels compiled by numba's own LLVM for a Cortex-M4F, as far as an object file, and what is wrong with it.

Runs in a process of its own with NUMBA_OPT=0: IR that was optimised for x86 carries facts of that machine.
Arrays become bare pointers, and no machine code is made for this PC. Then the layout and triple are
replaced, everything but the entry is made internal, and LLVM's own O2 pipeline runs for the target.
"""

import re
from collections.abc import Iterator
from typing import Any

import llvmlite.binding as llvm
import numba
from kernel_builds import Built
from numba.core.compiler_lock import global_compiler_lock
from problems import (
    Problem,
    belongs_to_fixed_point,
    double_problems,
    floating_problems,
    fused_problems,
)

from firmware.numerics.dialect import compile_once_for_all_literals, declare_only
from firmware.numerics.inner_code import make_inner
from firmware.numerics.signature import Signature
from host.pil.target_code import (
    FEATURES,
    HARD_FLOAT,
    LIBRARY_SYMBOLS,
    PROCESSOR,
    TRIPLE,
    undefined_symbols,
)

ADVICE = (
    (r"__aeabi_(u?l2[fd]|[fd]2u?lz)", "float32 and int64 meet in firmware.numerics.wide_integers"),
    (
        r"__aeabi_(u?ldivmod|u?idiv(mod)?)",
        "shift, or multiply by a reciprocal and shift; a loop that subtracts becomes a division too",
    ),
    (r"__aeabi_(d\w+|f2d|u?i2d)", "float64 arithmetic"),
    (r"fmodf?|powf?|floorf?|sinf?|cosf?|roundf?|truncf?|expf?|logf?", "the C library of the platform"),
    (
        r"NRT_\w+|numba_\w+|_?Py\w+",
        "needs Python's or numba's run-time library: allocation, text or exception",
    ),
)


def make_target_kernel(function: Any, signature: Signature | None) -> Any:
    """Decorator: what `host.pil.target_code.make_pointer_kernel` makes, as LLVM's intermediate code only."""
    options = {"error_model": "numpy", "boundscheck": False, "fastmath": False}
    dispatcher = make_inner(function, options | {"no_cpython_wrapper": True, "no_cfunc_wrapper": True})
    if signature is None:
        compile_once_for_all_literals(dispatcher)
    else:
        declare_only(dispatcher, re.sub(r"(\w+)\[::1\]", r"CPointer(\1)", signature.text))
    return dispatcher


class TargetBuilder:
    """Holds LLVM's target machine; `problems(built)` compiles one kernel with all it calls."""

    def __init__(self) -> None:
        llvm.initialize_all_targets()
        llvm.initialize_all_asmprinters()
        self._machine = llvm.Target.from_triple(TRIPLE).create_target_machine(
            cpu=PROCESSOR, features=FEATURES, opt=2, reloc="static"
        )

    def problems(self, built: Built) -> Iterator[Problem]:
        """What the target's code of a kernel with a signature breaks."""
        try:
            built.made.compile_declared()
        except numba.core.errors.NumbaError as error:
            yield Problem(built.name, "does not compile for bare pointers", str(error))
            return
        result = next(iter(built.made.overloads.values()))
        with global_compiler_lock:
            result.library._ensure_finalized()
        entry = result.fndesc.mangled_name
        module = self._module_for_target(str(result.library._final_module), entry)
        yield from double_problems(built.name, "unoptimised", str(module))
        if belongs_to_fixed_point(built.name):
            yield from floating_problems(built.name, "unoptimised", str(module), "")
        self._optimise(module, speed=2)
        yield from double_problems(built.name, "optimised for the target", str(module))
        assembly = self._machine.emit_assembly(module)
        yield from fused_problems(built.name, str(module), assembly)
        if belongs_to_fixed_point(built.name):
            yield from floating_problems(built.name, "optimised", str(module), assembly)
        if not HARD_FLOAT.search(assembly):
            yield Problem(built.name, "soft-float calls", f"no Tag_ABI_VFP_args in the object for {TRIPLE}")
        for symbol in undefined_symbols(self._machine.emit_object(module)):
            if not LIBRARY_SYMBOLS.fullmatch(symbol):
                yield Problem(built.name, "library call on the target", f"{symbol}: {_advice(symbol)}")

    def _module_for_target(self, ir: str, entry: str) -> Any:
        ir = re.sub(r"target datalayout = .*", f'target datalayout = "{self._machine.target_data}"', ir)
        ir = re.sub(r"target triple = .*", f'target triple = "{TRIPLE}"', ir)
        module = llvm.parse_assembly(ir.replace("@sqrtf(", "@llvm.sqrt.f32("))
        for function in module.functions:
            if not function.is_declaration and function.name != entry:
                function.linkage = "internal"
        remove_unreachable(self._machine, module)
        return module

    def _optimise(self, module: Any, speed: int) -> None:
        options = llvm.create_pipeline_tuning_options(speed_level=speed)
        options.loop_unrolling = True
        builder = llvm.create_pass_builder(self._machine, options)
        builder.getModulePassManager().run(module, builder)


def remove_unreachable(machine: Any, module: Any) -> None:
    """Drop what no entry of `module` reaches."""
    builder = llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options(speed_level=0))
    manager = llvm.create_new_module_pass_manager()
    manager.add_global_dead_code_eliminate_pass()
    manager.run(module, builder)


def _advice(symbol: str) -> str:
    for pattern, text in ADVICE:
        if re.fullmatch(pattern, symbol):
            return text
    return "the target has no such library"
