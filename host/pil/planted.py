"""Differences planted into the image on purpose, to see that the comparison catches them.

fma        products and sums are fused, as a compiler does with -ffp-contract=fast
constant   one constant, the most frequent factor, is changed by one unit in the last place
rounding   the processor rounds towards zero
"""

from __future__ import annotations

import re
from collections import Counter

PLANTS = ("fma", "constant", "rounding")
C_DEFINITIONS = {"rounding": ("-DROUND_TOWARDS_ZERO",)}
ULP_OF_FLOAT32 = 1 << 29
"""In the bits of a double, as which LLVM writes a float32."""

_PRODUCT_OR_SUM = re.compile(r"\b(fmul|fadd|fsub) (float|nnan)")
_FACTOR = re.compile(r"(fmul (?:contract )?float [^,]+, )(0x[0-9A-F]{16})")


def plant(name: str | None, ir: str) -> str:
    """LLVM's intermediate code with the difference `name` in it; None: as it is."""
    if name == "fma":
        return _PRODUCT_OR_SUM.sub(r"\1 contract \2", ir)
    if name == "constant":
        return _with_another_constant(ir)
    return ir


def _with_another_constant(ir: str) -> str:
    found = Counter(match[2] for match in _FACTOR.finditer(ir))
    if not found:
        return ir
    chosen = max(sorted(found), key=found.__getitem__)
    changed = f"0x{int(chosen, 16) + ULP_OF_FLOAT32:016X}"
    return _FACTOR.sub(lambda match: match[1] + (changed if match[2] == chosen else match[2]), ir)
