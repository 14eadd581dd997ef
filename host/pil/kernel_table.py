"""The C source that lets the monitor call kernels of any signature: one wrapper each, and their table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from firmware.numerics.signature import Argument, Signature
from host.pil.target_code import entry_symbol

C_TYPES = {
    "float32": "float",
    "boolean": "uint8_t",
    **{f"{sign}int{bits}": f"{sign}int{bits}_t" for sign in ("", "u") for bits in (8, 16, 32, 64)},
}
SIZES = {"float32": 4, "boolean": 1} | {
    name: int(name.lstrip("uint")) // 8 for name in C_TYPES if "int" in name
}


@dataclass(frozen=True, slots=True)
class TargetKernel:
    """A kernel of an image: its number there, its full name, its signature, the names of its parameters."""

    number: int
    name: str
    signature: Signature
    parameters: tuple[str, ...]


def table_source(kernels: Sequence[TargetKernel], identity: str) -> str:
    """The generated source file of an image."""
    parts = ['#include "kernels.h"', ""]
    parts += [_wrapper(kernel) for kernel in kernels]
    parts.append("const struct kernel kernels[] = {")
    parts += [
        f'    {{call_{kernel.number}, "{_kinds(kernel)}", {len(kernel.signature.results) + 1}}},'
        f" /* {kernel.name} */"
        for kernel in kernels
    ]
    parts += ["};", f"const uint8_t kernel_count = {len(kernels)};"]
    parts += [f'const char image_identity[17] = "{identity}";', ""]
    return "\n".join(parts)


def _kinds(kernel: TargetKernel) -> str:
    return "".join("a" if one.is_array else str(SIZES[one.scalar]) for one in kernel.signature.arguments)


def _wrapper(kernel: TargetKernel) -> str:
    signature = kernel.signature
    types = ["void *", "void **"]
    types += [C_TYPES[one.scalar] + (" *" if one.is_array else "") for one in signature.arguments]
    values = ["&out", "&exception"]
    values += [_value(one, place) for place, one in enumerate(signature.arguments)]
    members = "".join(f" {C_TYPES[one.scalar]} r{place};" for place, one in enumerate(signature.results))
    lines = [
        f"int32_t {entry_symbol(kernel.number)}({', '.join(types)});",
        f"static void call_{kernel.number}(const uint64_t *arguments, uint64_t *results)",
        "{",
        f"    struct {{{members or ' uint32_t nothing;'} }} out __attribute__((aligned(8))) = {{0}};",
        "    void *exception = 0;",
        f"    results[0] = (uint32_t){entry_symbol(kernel.number)}({', '.join(values)});",
    ]
    for place, one in enumerate(signature.results):
        value = f"slot_of_float(out.r{place})" if one.scalar == "float32" else f"(uint64_t)out.r{place}"
        lines.append(f"    results[{place + 1}] = {value};")
    return "\n".join([*lines, "}", ""])


def _value(argument: Argument, place: int) -> str:
    slot = f"arguments[{place}]"
    if argument.is_array:
        return f"({C_TYPES[argument.scalar]} *)(uintptr_t){slot}"
    if argument.scalar == "float32":
        return f"float_of({slot})"
    return f"({C_TYPES[argument.scalar]}){slot}"
