"""The on-board arithmetic in float64, to tell what float32 costs.

    strapdown = load("firmware.nav.strapdown", "float64")

gives a module with the same names, whose kernels, and all kernels they call, compute in float64: `np.float32`
in the source becomes `np.float64`, so do the signatures, and the polynomials of `trigonometry`, made for
float32, are replaced by the C library (`reference_trigonometry`). Arrays passed in must be float64 where the
original wants float32. Positions in 2⁻⁴⁰ rad stay integers.

For this to mean anything a kernel writes its constants with all their digits (`np.float32(1.0 / 6.0)`, not
0.16667) and plays no tricks with the bits of a float32.
"""

import ast
import functools
import importlib
from collections.abc import Callable
from types import ModuleType
from typing import Any

from firmware.numerics.dialect import INTERPRETED, compile_lazily, interpret
from firmware.numerics.signature import Signature, parse_signature
from firmware.numerics.variants import KernelVariant

PRECISIONS = ("float32", "float64")


def load(module: str, precision: str) -> ModuleType:
    """`module` ("firmware.nav.strapdown") computing in `precision`, "float32" (as it is) or "float64"."""
    if precision not in PRECISIONS:
        raise ValueError(f"precision {precision!r} is not known; one of {', '.join(PRECISIONS)}")
    return importlib.import_module(module) if precision == "float32" else _float64_variant().load(module)


@functools.cache
def _float64_variant() -> KernelVariant:
    return KernelVariant(
        "float64",
        _make_float64_kernel,
        rewrite=lambda tree: _Float64Writer().visit(tree),
        replacements={"firmware.numerics.trigonometry": "firmware.numerics.reference_trigonometry"},
    )


def _make_float64_kernel(function: Callable[..., Any], signature: Signature | None) -> Any:
    wide = None if signature is None else parse_signature(signature.text.replace("float32", "float64"))
    return interpret(function, wide) if INTERPRETED else compile_lazily(function, wide, kept_as="float64")


class _Float64Writer(ast.NodeTransformer):
    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        self.generic_visit(node)
        if node.attr == "float32":
            node.attr = "float64"
        return node
