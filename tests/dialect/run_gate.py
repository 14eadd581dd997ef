"""One half of the gate, in a process of its own: prints its findings as JSON in the last line.

    python run_gate.py host|target [firmware.nav | samples.py]

host:   compiled for this PC as the product is: float64, fused multiply-add, 64-bit loops, and the same bits
        as interpreted. target: compiled for the Cortex-M4F; needs NUMBA_OPT=0 in the environment.
"""

import functools
import json
import os
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import bit_comparison
import generated_inputs
import host_code
import numpy as np
import target_build
from kernel_builds import Built, Decorate, build_product, build_samples
from problems import Problem

from firmware.numerics.dialect import compile_lazily

TESTS = Path(__file__).resolve().parents[1]


def assert_subnormals() -> None:
    """A library in the process may have set flush-to-zero; nothing here would mean anything then."""
    smallest = np.float32(1.1754944e-38)
    assert smallest * np.float32(0.5) > np.float32(0.0), "this process flushes subnormal numbers to zero"


def host_problems(build: Callable[[str, Decorate], dict[str, Built]]) -> Iterator[Problem]:
    """All findings on the code for this PC."""
    interpreted = build("interpreted", bit_comparison.interpret_strictly)
    compiled = build("compiled", functools.partial(compile_lazily, kept_as=None))
    inputs = generated_inputs.owners_inputs(TESTS)
    for name, built in compiled.items():
        if built.signature is not None:
            problem = host_code.compile_problem(built)
            if problem is not None:
                yield problem
                continue
            yield from host_code.problems(built)
            yield from bit_comparison.compare(interpreted[name], built, inputs.get(name))
    yield from host_code.problems_of_all(compiled.values())


def target_problems(build: Callable[[str, Decorate], dict[str, Built]]) -> Iterator[Problem]:
    """All findings on the code for the Cortex-M4F."""
    assert os.environ.get("NUMBA_OPT") == "0", "set NUMBA_OPT=0 before numba is imported"
    builder = target_build.TargetBuilder()
    for built in build("target", target_build.make_pointer_kernel).values():
        if built.signature is not None:
            yield from builder.problems(built)


def main(half: str, what: str = "firmware") -> None:
    """Print {"kernels": number, "seconds": float, "problems": [{kernel, rule, detail}, …]}."""
    started = time.monotonic()
    assert_subnormals()
    names: set[str] = set()

    def build(variant: str, decorate: Decorate) -> dict[str, Built]:
        if what.endswith(".py"):
            built = build_samples(Path(what), decorate)
        else:
            built = build_product(variant, decorate, what)
        names.update(built)
        return built

    check = {"host": host_problems, "target": target_problems}[half]
    found = [{"kernel": p.kernel, "rule": p.rule, "detail": p.detail} for p in check(build)]
    report = {"kernels": sorted(names), "seconds": time.monotonic() - started, "problems": found}
    print("\n" + json.dumps(report))


if __name__ == "__main__":
    main(*sys.argv[1:])
