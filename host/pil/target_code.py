"""Kernels compiled by numba's own LLVM for the Cortex-M4F of an STM32F405, as far as one object file.

Wants a process of its own with NUMBA_OPT=0 (see `compile_kernels`): IR that was optimised for x86 carries
facts of that machine. Arrays become bare pointers; what several kernels call is linked once; everything but
the entries is internal; then LLVM's O2 pipeline runs for the target. An entry is called as

    int32_t nt_kernel_<n>(void *result, void **exception, arguments…)

with the hard-float calling convention; anything but zero is an error.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterable
from typing import Any

import llvmlite.binding as llvm
import numba

from firmware.numerics.dialect import compile_once_for_all_literals, declare_only
from firmware.numerics.signature import Signature

TRIPLE = "thumbv7em-unknown-none-eabihf"  # without "unknown" LLVM silently calls with soft floats
PROCESSOR = "cortex-m4"
FEATURES = "+thumb-mode,+vfp4d16sp,-fp64,-d32,-neon"
LIBRARY_SYMBOLS = re.compile(r"(__aeabi_)?mem(cpy|set|clr|move)[48]?")
"""What the image brings along."""
HARD_FLOAT = re.compile(r"\.eabi_attribute\s+28,\s*1\b")
UNROLLED, ROLLED = "unrolled", "rolled"
"""Loops of the kernels: rolled ones take a third less flash, and more instructions."""
INLINING_THRESHOLD = 100
"""Of LLVM; its own 225 makes the image of a filter with 36 states a third larger."""
FUSED = re.compile(r"\bvfn?m[as]\.f32\b")


def make_pointer_kernel(function: Any, signature: Signature | None) -> Any:
    """Decorator: the dispatcher of `function`, to be compiled with bare pointers for its arrays."""
    options: dict[str, Any] = {"error_model": "numpy", "boundscheck": False, "fastmath": False}
    nothing_for_python: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
    dispatcher: Any = numba.njit(**options, **nothing_for_python)(function)
    if signature is None:
        compile_once_for_all_literals(dispatcher)
        return dispatcher
    return declared(dispatcher, signature.text)


def declared(dispatcher: Any, signature: str) -> Any:
    """A kernel with this signature, which inner kernels have not by themselves."""
    if not hasattr(dispatcher, "compile_declared"):
        declare_only(dispatcher, re.sub(r"(\w+)\[::1\]", r"CPointer(\1)", signature))
    return dispatcher


def entry_symbol(number: int) -> str:
    """Name of an entry in the object file."""
    return f"nt_kernel_{number}"


class TargetMachine:
    """LLVM's machine for the Cortex-M4F."""

    def __init__(self, unrolling: bool) -> None:
        self._unrolling = unrolling
        llvm.initialize_all_targets()
        llvm.initialize_all_asmprinters()
        self.llvm: Any = llvm.Target.from_triple(TRIPLE).create_target_machine(
            cpu=PROCESSOR, features=FEATURES, opt=2, reloc="static"
        )

    def module(self, kernels: Iterable[Any]) -> Any:
        """All `kernels` (of `make_pointer_kernel`), in this order, in one optimised module."""
        whole, entries = None, []
        for kernel in kernels:
            kernel.compile_declared()
            result = next(iter(kernel.overloads.values()))
            entries.append(result.fndesc.mangled_name)
            part = llvm.parse_assembly(self._retargeted(str(result.library._final_module)))
            if whole is None:
                whole = part
            else:
                whole.link_in(part)
        assert whole is not None, "no kernel"
        for one in (*whole.functions, *whole.global_variables):
            if not one.is_declaration and one.name not in entries:
                one.linkage = "internal"
        for number, name in enumerate(entries):
            whole.get_function(name).name = entry_symbol(number)
        self._optimise(whole)
        return whole

    def _retargeted(self, ir: str) -> str:
        ir = re.sub(r"target datalayout = .*", f'target datalayout = "{self.llvm.target_data}"', ir)
        ir = re.sub(r"target triple = .*", f'target triple = "{TRIPLE}"', ir)
        return ir.replace("@sqrtf(", "@llvm.sqrt.f32(")

    def _optimise(self, module: Any) -> None:
        first = llvm.create_pass_builder(self.llvm, llvm.create_pipeline_tuning_options(speed_level=0))
        unreachable = llvm.create_new_module_pass_manager()
        unreachable.add_global_dead_code_eliminate_pass()
        unreachable.run(module, first)
        options = llvm.create_pipeline_tuning_options(speed_level=2)
        options.loop_unrolling = self._unrolling
        options.inlining_threshold = INLINING_THRESHOLD
        builder = llvm.create_pass_builder(self.llvm, options)
        builder.getModulePassManager().run(module, builder)


def undefined_symbols(image: bytes) -> list[str]:
    """Names that the 32-bit little-endian ELF object expects from elsewhere (System V ABI, chapter 4)."""
    assert image[:6] == b"\x7fELF\x01\x01", "not a 32-bit little-endian ELF file"
    section_offset = struct.unpack_from("<I", image, 32)[0]
    size, count = struct.unpack_from("<HH", image, 46)
    sections = [struct.unpack_from("<10I", image, section_offset + n * size) for n in range(count)]
    names = []
    for _, kind, _, _, offset, length, link, *_ in sections:
        if kind != 2:  # SHT_SYMTAB
            continue
        text = sections[link][4]
        for at in range(offset + 16, offset + length, 16):
            name, _, _, _, _, section = struct.unpack_from("<IIIBBH", image, at)
            if section == 0:  # SHN_UNDEF
                end = image.index(b"\0", text + name)
                names.append(image[text + name : end].decode())
    return names
