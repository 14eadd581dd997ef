"""The gate itself: samples that break one rule each are caught, samples that break none are not."""

import re
from pathlib import Path

import numpy as np
import pytest
import target_build
from bit_comparison import compare
from gate_runs import run_half
from host_code import problems as host_problems
from kernel_builds import Built, build_samples
from problems import fused_problems
from source_rules import violations
from target_build import TargetBuilder

from firmware.numerics.dialect import compile_lazily, declare_only
from firmware.numerics.signature import parse_signature
from host.pil.strict_run import interpret_strictly
from host.pil.target_code import make_pointer_kernel, undefined_symbols

HERE = Path(__file__).resolve().parent
BAD_KERNELS = HERE / "bad_kernels.py"
GOOD_KERNELS = HERE / "good_kernels.py"


def declared_breaches(finder):
    """(kernel, rule) of all comments above the samples that name `finder`: source, host or target."""
    text = BAD_KERNELS.read_text(encoding="utf-8")
    found = []
    for comment, name in re.findall(r"^# (.*)\n@kernel.*\ndef (\w+)", text, re.MULTILINE):
        breaches = dict(breach.split(": ") for breach in comment.split("; "))
        assert breaches.keys() <= {"source", "host", "target"}
        if finder in breaches:
            found.append((name, breaches[finder]))
    return found


@pytest.fixture(scope="module")
def host_report():
    return run_half("host", str(BAD_KERNELS))


@pytest.fixture(scope="module")
def target_report():
    return run_half("target", str(BAD_KERNELS))


@pytest.fixture(scope="module")
def source_violations():
    return violations_in(BAD_KERNELS)


def _as_it_is(function, signature):
    return function


def violations_in(path):
    functions = [sample.function for sample in build_samples(path, _as_it_is).values()]
    return violations(functions, all_kernels=functions)


@pytest.mark.parametrize(("kernel", "rule"), declared_breaches("host"))
def test_breach_is_found_on_the_host(host_report, kernel, rule):
    assert rule in host_report.rules_broken_by(kernel), host_report.text()


@pytest.mark.parametrize(("kernel", "rule"), declared_breaches("target"))
def test_breach_is_found_on_the_target(target_report, kernel, rule):
    assert rule in target_report.rules_broken_by(kernel), target_report.text()


@pytest.mark.parametrize(("kernel", "rule"), declared_breaches("source"))
def test_breach_is_found_in_the_source(source_violations, kernel, rule):
    lines = BAD_KERNELS.read_text(encoding="utf-8").splitlines()
    first = next(n for n, line in enumerate(lines, 1) if line.startswith(f"def {kernel}("))
    after = [n for n, line in enumerate(lines, 1) if line.startswith("def ") and n > first]
    last = min(after, default=len(lines) + 1)
    assert rule in {found.rule for found in source_violations if first <= found.line < last}


def test_only_declared_breaches_are_found_in_the_source(source_violations):
    declared = {rule for _, rule in declared_breaches("source")}
    assert {found.rule for found in source_violations} == declared


def test_message_tells_place_rule_text_and_right_form(source_violations):
    (message,) = [str(found) for found in source_violations if found.rule == "power"]
    line = BAD_KERNELS.read_text(encoding="utf-8").splitlines().index("    return x**3") + 1
    assert message == f"{BAD_KERNELS}:{line}: power: `x ** 3`; write instead: x * x"


def test_good_kernels_break_no_rule_of_the_source():
    assert not violations_in(GOOD_KERNELS)


@pytest.mark.parametrize("half", ["host", "target"])
def test_good_kernels_pass(half):
    report = run_half(half, str(GOOD_KERNELS))
    assert not report.problems, report.text()


def built(function, signature, decorate):
    parsed = parse_signature(signature)
    return Built(function.__name__, function, parsed, decorate(function, parsed))


def multiply_add(x, y, z):
    return x * y + z


FLOATS3 = "float32(float32, float32, float32)"


def test_licence_to_fuse_is_found():
    import numba

    def decorate(function, signature):
        dispatcher = numba.njit(fastmath=True)(function)
        declare_only(dispatcher, signature.text)
        dispatcher.compile_declared()
        return dispatcher

    assert {found.rule for found in host_problems(built(multiply_add, FLOATS3, decorate))} == {
        "fused multiply-add"
    }


def test_product_without_licence_is_not_fused():
    good = built(multiply_add, FLOATS3, lambda function, signature: compile_lazily(function, signature, None))
    good.made.compile_declared()
    assert not list(host_problems(good))


@pytest.mark.parametrize(
    "assembly",
    ["\tvfmadd213ss\t%xmm2, %xmm1, %xmm0", "\tvfnmsub231ps (%rax), %ymm0, %ymm1", "\tvfma.f32\ts2, s0, s1"],
)
def test_fused_instructions_are_found(assembly):
    assert [found.detail for found in fused_problems("k", "", assembly)]


@pytest.mark.parametrize("assembly", ["\tvmulss\t%xmm1, %xmm0, %xmm0", "\tvmla.f32\ts2, s0, s1"])
def test_separately_rounded_instructions_are_allowed(assembly):
    assert not list(fused_problems("k", "", assembly))


def test_soft_float_triple_is_found(monkeypatch):
    monkeypatch.setattr(target_build, "TRIPLE", "thumbv7em-none-eabihf")
    sample = built(multiply_add, FLOATS3, make_pointer_kernel)
    assert "soft-float calls" in {found.rule for found in TargetBuilder().problems(sample)}


def test_nan_of_another_sign_is_no_difference():
    def interpreted(x):
        return np.float32(-np.nan)

    def compiled(x):
        return np.float32(np.nan)

    pair = [built(one, "float32(float32)", interpret_strictly) for one in (interpreted, compiled)]
    assert not list(compare(*pair, inputs=None))


def test_difference_names_place_and_values():
    def interpreted(p):
        p[3] = np.float32(1.0)

    def compiled(p):
        p[3] = np.float32(2.0)

    pair = [built(one, "void(float32[::1])", interpret_strictly) for one in (interpreted, compiled)]
    (found,) = compare(*pair, inputs=None)
    assert "argument 0[3]: np.float32(1.0) interpreted, np.float32(2.0) compiled" in found.detail


def test_owners_inputs_are_used_instead_of_generated_ones():
    def kernel(p, n):
        return p[n]

    pair = [built(kernel, "float32(float32[::1], int64)", interpret_strictly) for _ in range(2)]
    assert list(compare(*pair, inputs=lambda rng: (np.zeros(4, np.float32), 4)))
    assert not list(compare(*pair, inputs=lambda rng: (np.zeros(4, np.float32), rng.integers(0, 4))))


def test_undefined_symbols_of_an_object_file():
    with pytest.raises(AssertionError, match="not a 32-bit little-endian ELF"):
        undefined_symbols(b"\x7fELF\x02\x01" + bytes(100))
