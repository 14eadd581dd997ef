"""The estimate of cycles: counted code computes what the kernel does, operations have prices."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from firmware.numerics.trigonometry import arc_tangent2
from host.cli.main import app
from host.cycles.counted_code import CountedKernel
from host.cycles.estimate import PricedKernel
from host.cycles.prices import BRANCH, DIVISION, FLOAT, MEMORY, WIDE, Pricing
from host.cycles.whole_code import whole_code

FINITE = st.floats(-1e6, 1e6, width=32)
COUNTED = CountedKernel(whole_code("firmware.numerics.trigonometry", "arc_tangent2"))


@settings(deadline=None)  # the first example compiles
@given(FINITE, FINITE)
def test_counted_code_gives_the_bits_of_the_kernel(y: float, x: float) -> None:
    assert np.float32(COUNTED(y, x)).tobytes() == np.float32(arc_tangent2(y, x)).tobytes()


def test_a_quaternion_product_is_sixteen_products_and_twelve_sums() -> None:
    kernel = PricedKernel("firmware.numerics.quaternion", "quaternion_product")
    for _ in range(3):
        kernel(*np.linspace(0.1, 0.8, 8).tolist())
    cycles = kernel.cycles()
    assert cycles.calls == 3
    assert cycles.by_kind[FLOAT] == 3 * 2 * (16 + 12)
    assert cycles.by_kind[DIVISION] == cycles.by_kind[WIDE] == 0


def test_a_root_is_the_librarys() -> None:
    kernel = PricedKernel("firmware.numerics.trigonometry", "square_root")
    kernel(2.0)
    assert kernel.cycles().by_kind[DIVISION] == 28


def test_only_what_ran_is_paid_for() -> None:
    """The arctangent divides, but not what is no number."""
    for arguments, divisions in (((1.0, 2.0), 24), ((float("nan"), 1.0), 0)):
        kernel = PricedKernel("firmware.numerics.trigonometry", "arc_tangent2")
        kernel(*arguments)
        assert kernel.cycles().by_kind[DIVISION] == divisions


CODE = (
    ("%a = sext i32 %x to i64", (WIDE, 2)),
    ("%b = sext i32 %y to i64", (WIDE, 2)),
    ("%p = mul nsw i64 %a, %b", (WIDE, 5)),
    ("%q = mul i64 %p, %p", (WIDE, 14)),
    ("%r = ashr i64 %q, 30", (WIDE, 3)),
    ("%s = ashr i64 %r, 1", (WIDE, 2)),
    ("%t = add nsw i64 %s, 1", (WIDE, 4)),
    ("store i64 %t, ptr %out, align 8", (MEMORY, 2)),
    ("%i = sext i32 %n to i64", (MEMORY, 1)),
    ("%j = add nsw i64 %i, 4", (MEMORY, 1)),
    ("%at = getelementptr inbounds float, ptr %s0, i64 %j", (MEMORY, 1)),
    ("%f = load float, ptr %at, align 4", (MEMORY, 1)),
    ("%g = fmul float %f, %f", (FLOAT, 2)),
    ("%h = fdiv float %g, %f", (DIVISION, 24)),
    ("%k = call float @sqrtf(float %h)", (DIVISION, 28)),
    ("%l = tail call float @llvm.fabs.f32(float %k)", (FLOAT, 2)),
    ("%m = select i1 %c, float %l, float %k", (FLOAT, 2)),
    ("br i1 %c, label %B1, label %B2", (BRANCH, 4)),
    ("%z = call i32 @other(ptr %s0)", (BRANCH, 8)),
    ("ret i32 0", (BRANCH, 4)),
)


@pytest.mark.parametrize("place", range(len(CODE)))
def test_prices(place: int) -> None:
    instruction, (kind, cycles) = CODE[place]
    price = Pricing([one for one, _ in CODE]).price(instruction)
    assert (price.kind, price.cycles) == (kind, cycles)


@pytest.mark.soak
def test_table_of_cycles() -> None:
    result = CliRunner().invoke(app, ["table", "cycles", "--json", "-", "-q"])
    assert result.exit_code == 0, result.output
    told: dict[str, Any] = json.loads(result.stdout)
    by_name = {one["arithmetic"]: one for one in told["arithmetics"]}
    for one in by_name.values():
        assert 2_000 < one["solution_cycles"] < 52_500
        assert one["solution_s"] == pytest.approx(one["solution_cycles"] / 150e6)
        assert one["document_solution_s"] == 0.35e-3
    assert "float" not in by_name["fixed"]["kernels"]["iteration"]["by_kind"]
    assert by_name["fixed"]["solution_cycles"] > by_name["float32"]["kernels"]["iteration"]["cycles_per_call"]
