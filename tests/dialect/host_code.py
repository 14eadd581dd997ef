"""What numba made of the kernels for this PC: optimised IR, machine code and the types it found."""

import functools
from collections.abc import Iterable, Iterator
from typing import Any

import llvmlite.binding as llvm
from kernel_builds import Built
from numba.core import types
from numba.core.errors import NumbaError
from problems import (
    Problem,
    belongs_to_fixed_point,
    double_problems,
    floating_problems,
    fused_problems,
)
from target_build import remove_unreachable

from firmware.numerics.dialect import compiled_forms


def compile_problem(built: Built) -> Problem | None:
    """Compile a kernel with a signature; what numba says when it cannot."""
    try:
        built.made.compile_declared()
    except NumbaError as error:
        return Problem(built.name, "does not compile", str(error))
    return None


def problems(built: Built) -> Iterator[Problem]:
    """Float64, fused multiply-adds, floats in fixed point: in one compiled kernel and in all it calls."""
    result = next(iter(built.made.overloads.values()))
    # The optimised code as it is kept in the cache, for other kernels to be linked with.
    module = llvm.parse_assembly(str(result.library._get_module_for_linking()))
    for function in module.functions:
        if not function.is_declaration:
            function.linkage = "external" if function.name == result.fndesc.mangled_name else "internal"
    machine = _this_machine()
    remove_unreachable(machine, module)
    ir = str(module)
    assembly = machine.emit_assembly(module)
    yield from double_problems(built.name, "optimised", ir)
    yield from fused_problems(built.name, ir, assembly)
    if belongs_to_fixed_point(built.name):
        yield from floating_problems(built.name, "optimised", ir, assembly)


@functools.cache
def _this_machine() -> Any:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    target = llvm.Target.from_default_triple()
    features = llvm.get_host_cpu_features().flatten()
    return target.create_target_machine(cpu=llvm.get_host_cpu_name(), features=features, opt=3)


def problems_of_all(built: Iterable[Built]) -> Iterator[Problem]:
    """Kernels that nothing compiled, and loops with 64-bit counters; after all others were compiled here."""
    for one in built:
        forms = compiled_forms(one.made)
        if not forms:
            advice = "declare its signature, or remove it: no kernel with a signature calls it"
            yield Problem(one.name, "no signature", advice)
        for result in forms:
            for name, kind in result.type_annotation.typemap.items():
                if isinstance(kind, types.RangeType) and kind.dtype.bitwidth > 32:
                    where = f"{_line(result, name)}: one bound of the range is an int64"
                    yield Problem(one.name, "64-bit loop", f"{where}; write np.int32(...) around it")


def _line(result: Any, variable: str) -> str:
    annotation = result.type_annotation
    for block in annotation.blocks.values():
        for statement in block.body:
            if variable in {var.name for var in statement.list_vars()}:
                return f"line {statement.loc.line}"
    return "line ?"
