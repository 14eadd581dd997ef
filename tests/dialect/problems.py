"""What compiled code of a kernel must not contain, found in LLVM's and the assembler's text."""

import re
from collections.abc import Iterator
from dataclasses import dataclass

FUSED_IR = re.compile(
    r"@llvm\.(?:fma|fmuladd)\.\w+|\b(?:fadd|fsub|fmul|fdiv) [a-z ]*\b(?:fast|contract|reassoc)\b"
)
FUSED_X86 = re.compile(r"\bvfn?m(?:add|sub)\w*")
FUSED_ARM = re.compile(r"\bvfn?m[as]\.f32\b")
DOUBLE = re.compile(r"^.*\bdouble\b.*$", re.MULTILINE)
# A type in LLVM's text, not a part of a name or of an attribute like "use-soft-float".
FLOATING = re.compile(
    r"^.*(?<![-\w.@%\"$])(?:half|bfloat|float|double|fp128|x86_fp80)\b(?![-\"]).*$", re.MULTILINE
)
FLOATING_X86 = re.compile(
    r"^\s*v?(?:(?:add|sub|mul|div|sqrt|min|max|round|u?comi|cmp\w*|rcp|rsqrt)[sp][sd]|cvt\w+|f(?:ld|st|i?add|i?mul)\w*)\b.*$",
    re.MULTILINE,
)
FLOATING_ARM = re.compile(r"^\s*v\w+\.f(?:16|32|64)\b.*$", re.MULTILINE)


@dataclass(frozen=True, slots=True)
class Problem:
    """One breach of the dialect found in compiled code or in results."""

    kernel: str
    rule: str
    detail: str

    def __str__(self) -> str:
        return f"{self.kernel}: {self.rule}: {self.detail}"


def double_problems(kernel: str, which: str, ir: str) -> Iterator[Problem]:
    """The first use of float64 in `ir`."""
    if found := DOUBLE.search(ir):
        yield Problem(kernel, "float64", f"in the {which} code: {found[0].strip()}")


def fused_problems(kernel: str, ir: str, assembly: str) -> Iterator[Problem]:
    """The first fused multiply-add, or licence to make one."""
    for pattern, text in ((FUSED_IR, ir), (FUSED_X86, assembly), (FUSED_ARM, assembly)):
        if found := pattern.search(text):
            yield Problem(kernel, "fused multiply-add", found[0])


def belongs_to_fixed_point(kernel: str) -> bool:
    """Whether a kernel has to do without floating point: by its package or module, a sample by its name."""
    *packages, name = kernel.split(".")
    return bool({"fixed", "fixed_steps"} & set(packages)) or name.startswith("in_fixed_point_")


def floating_problems(kernel: str, which: str, ir: str, assembly: str) -> Iterator[Problem]:
    """The first floating-point type, of any width, and the first such instruction."""
    for pattern, text in ((FLOATING, ir), (FLOATING_X86, assembly), (FLOATING_ARM, assembly)):
        if found := pattern.search(text):
            yield Problem(kernel, "float in fixed point", f"in the {which} code: {found[0].strip()}")
            return
