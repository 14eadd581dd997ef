"""One half of the gate, in a process of its own: prints its findings as JSON in the last line.

    python run_gate.py host|target [firmware.nav | samples.py]

host:   as the product runs them on this PC: no float64, no fused multiply-add, and the same bits as
        interpreted. target: compiled anew, for the Cortex-M4F; needs NUMBA_OPT=0 in the environment; also
        finds what only a fresh compilation tells, 64-bit loops and kernels that nothing calls.
"""

import dataclasses
import functools
import json
import os
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import bit_comparison
import host_code
import llvmlite
import numba
import numpy as np
import target_build
from kernel_builds import build_product, build_samples, registered_product
from problems import Problem

from firmware.numerics.cache_folder import kernel_cache_folder
from firmware.numerics.dialect import compile_lazily
from firmware.numerics.subnormals import check_subnormals
from host.pil import generated_inputs, strict_run, target_code

TESTS = Path(__file__).resolve().parents[1]


def host_problems(what: str) -> Iterator[Problem]:
    """All findings on the code for this PC."""
    if what.endswith(".py"):
        compiled = build_samples(Path(what), functools.partial(compile_lazily, kept_as=None))
        interpreted = build_samples(Path(what), strict_run.interpret_strictly)
    else:
        compiled = registered_product(what)
        interpreted = build_product("interpreted", strict_run.interpret_strictly, what)
    inputs = generated_inputs.owners_inputs(TESTS)
    for name, built in compiled.items():
        if built.signature is None:
            continue
        problem = host_code.compile_problem(built)
        if problem is not None:
            yield problem
            continue
        yield from host_code.problems(built)
        yield from bit_comparison.compare(interpreted[name], built, inputs.get(name))


def target_problems(what: str) -> Iterator[Problem]:
    """All findings on the code for the Cortex-M4F."""
    assert os.environ.get("NUMBA_OPT") == "0", "set NUMBA_OPT=0 before numba is imported"
    if what.endswith(".py"):
        kernels = build_samples(Path(what), target_build.make_target_kernel)
    else:
        kernels = build_product("target", target_build.make_target_kernel, what)
    builder = target_build.TargetBuilder()
    for built in kernels.values():
        if built.signature is not None:
            yield from builder.problems(built)
    yield from host_code.problems_of_all(kernels.values())


def findings(half: str, what: str) -> list[dict[str, str]]:
    """All problems of one half; those of the product on the target are kept while no source changes."""
    if half == "host":
        return [dataclasses.asdict(problem) for problem in host_problems(what)]
    if what.endswith(".py"):
        return [dataclasses.asdict(problem) for problem in target_problems(what)]
    gate = "".join(
        path.read_text(encoding="utf-8")
        for path in sorted([*Path(__file__).parent.glob("*.py"), Path(target_code.__file__)])
    )
    versions = (what, gate, sys.version, numba.__version__, llvmlite.__version__, np.__version__)
    folder = kernel_cache_folder("target gate" + repr(versions))
    kept = folder / "problems.json" if folder is not None else None
    if kept is not None and kept.exists():
        return list(json.loads(kept.read_text(encoding="utf-8")))
    found = [dataclasses.asdict(problem) for problem in target_problems(what)]
    if kept is not None:
        unfinished = kept.with_suffix(f".{os.getpid()}")
        unfinished.write_text(json.dumps(found), encoding="utf-8")
        unfinished.replace(kept)
    return found


def main(half: str, what: str = "firmware") -> None:
    """Print {"seconds": processor time, "problems": [{kernel, rule, detail}, …]}."""
    check_subnormals()
    found = findings(half, what)
    print("\n" + json.dumps({"seconds": time.process_time(), "problems": found}))


if __name__ == "__main__":
    main(*sys.argv[1:])
