"""Differences planted into the image on purpose, to see that the comparison catches them.

fma        products and sums are fused, as a compiler does with -ffp-contract=fast
constant   constant factors are off by one unit in the last place
rounding   the processor rounds towards zero; in fixed point, what would round to the nearest rounds down
"""

from __future__ import annotations

import re

PLANTS = ("fma", "constant", "rounding")
C_DEFINITIONS = {"rounding": ("-DROUND_TOWARDS_ZERO",)}
ULP_OF_FLOAT32 = 1 << 29
"""In the bits of a double, as which LLVM writes a float32."""

_FACTOR = re.compile(r"(fmul float [^,]+, )(0x[0-9A-F]{16})")
_PRODUCT = re.compile(r"^\s*(%\S+) = fmul float ([^,\s]+), ([^,\s]+)", re.MULTILINE)
_SUM = re.compile(r"^(\s*%\S+ = )fadd float ([^,\s]+), ([^,\s]+)", re.MULTILINE)
_FUNCTION = re.compile(r"^define .*?^\}", re.MULTILINE | re.DOTALL)
_LARGE = 1 << 16
"""Integer factors from here on are constants of fixed-point formulas, not sizes of elements."""
_INTEGER_FACTOR = re.compile(r"(= mul (?:nuw |nsw )*i64 [^,]+, )(\d+)$", re.MULTILINE)
_HALF = re.compile(r"^(\s*(%\S+) = add (?:nuw |nsw )*i64 [^,]+, )(\d+)$", re.MULTILINE)
_SHIFT = re.compile(r"= ashr (?:exact )?i64 (%\S+), (\d+)$", re.MULTILINE)
_FUSED = "declare float @llvm.fma.f32(float, float, float)\n"


def plant(name: str | None, ir: str) -> str:
    """LLVM's optimised intermediate code with the difference `name` in it; None: as it is."""
    if name == "fma":
        return _FUNCTION.sub(lambda match: _fused_function(match[0]), ir) + _FUSED
    if name == "constant":
        return _with_other_constants(ir)
    if name == "rounding":
        return _FUNCTION.sub(lambda match: _rounding_down(match[0]), ir)
    return ir


def _fused_function(text: str) -> str:
    products = {name: (one, other) for name, one, other in _PRODUCT.findall(text)}

    def fuse(match: re.Match[str]) -> str:
        for factor, term in ((match[2], match[3]), (match[3], match[2])):
            if factor in products:
                one, other = products[factor]
                return f"{match[1]}call float @llvm.fma.f32(float {one}, float {other}, float {term})"
        return match[0]

    return _SUM.sub(fuse, text)


def _with_other_constants(ir: str) -> str:
    ir = _FACTOR.sub(lambda match: f"{match[1]}0x{int(match[2], 16) + ULP_OF_FLOAT32:016X}", ir)
    return _INTEGER_FACTOR.sub(lambda match: match[1] + str(int(match[2]) + (int(match[2]) >= _LARGE)), ir)


def _rounding_down(text: str) -> str:
    """Halves of a unit that are added before it is shifted to are left out."""
    shifts = dict(_SHIFT.findall(text))

    def without_half(match: re.Match[str]) -> str:
        is_half = match[2] in shifts and int(match[3]) == 1 << int(shifts[match[2]]) >> 1
        return match[1] + ("0" if is_half else match[3])

    return _HALF.sub(without_half, text)
