"""Compiles kernels to one object file, in a process of its own.

    NUMBA_OPT=0 python -m host.pil.compile_kernels OBJECT unrolled|rolled [PLANT] < kernels

Reads kernels from standard input, the full name and the signature of one a line; a kernel that is declared
without one becomes an entry with it. Writes the object file and prints its
findings as JSON: {"undefined": […], "fused": n, "hard_float": true, "llvm": …, "numba": …}.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import llvmlite.binding as llvm
import numba

from firmware.numerics.subnormals import check_subnormals
from firmware.numerics.variants import KernelVariant
from host.pil.planted import plant
from host.pil.target_code import (
    FUSED,
    HARD_FLOAT,
    LIBRARY_SYMBOLS,
    UNROLLED,
    TargetMachine,
    declared,
    make_pointer_kernel,
    undefined_symbols,
)


def main(target: str, loops: str, planted: str | None = None) -> None:
    """Compile what standard input names."""
    assert os.environ.get("NUMBA_OPT") == "0", "set NUMBA_OPT=0 before numba is imported"
    check_subnormals()
    wanted = dict(line.split(" ", 1) for line in sys.stdin.read().splitlines())
    variant = KernelVariant("target", make_pointer_kernel)
    for name in wanted:
        variant.load(name.rpartition(".")[0])
    machine = TargetMachine(unrolling=loops == UNROLLED)
    kernels = {name: variant.kernels[name] for name in wanted}
    module = machine.module([declared(kernel, wanted[name]) for name, kernel in kernels.items()])
    if planted is not None:
        module = llvm.parse_assembly(plant(planted, str(module)))
    assembly = machine.llvm.emit_assembly(module)
    code = machine.llvm.emit_object(module)
    Path(target).write_bytes(code)
    findings = {
        "undefined": [name for name in undefined_symbols(code) if not LIBRARY_SYMBOLS.fullmatch(name)],
        "fused": len(FUSED.findall(assembly)),
        "hard_float": HARD_FLOAT.search(assembly) is not None,
        "llvm": ".".join(map(str, llvm.llvm_version_info)),
        "numba": numba.__version__,
    }
    print(json.dumps(findings))


if __name__ == "__main__":
    main(*sys.argv[1:])
