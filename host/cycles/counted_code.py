"""Code whose blocks count how often they run.

Works on the text of LLVM's intermediate code: a function is `define … {`, labels, instructions, `}`; each
block gets an addition to a counter of its own behind its phi instructions.
"""

from __future__ import annotations

import ctypes
import re
from dataclasses import dataclass, field
from typing import Any

import llvmlite.binding as llvm
import numpy as np

from host.cycles.whole_code import WholeCode, plain_machine

LABEL = re.compile(r'^("[^"]+"|[\w.$-]+):')
SCALARS: dict[str, Any] = {"float32": ctypes.c_float, "float64": ctypes.c_double, "int32": ctypes.c_int32}
RESULT_BYTES = 16


@dataclass(slots=True)
class Block:
    """Instructions that run one after another, without their indentation."""

    function: str
    instructions: list[str] = field(default_factory=list)


class CountedKernel:
    """A kernel with a signature; call it with arrays and numbers as the original.

    `counts()` goes with `blocks`.
    """

    def __init__(self, code: WholeCode) -> None:
        text, self.blocks = _with_counters(str(code.module))
        self._engine = llvm.create_mcjit_compiler(llvm.parse_assembly(text), plain_machine())
        self._engine.finalize_object()
        kinds = [ctypes.c_void_p if one.is_array else _scalar(one.scalar) for one in code.signature.arguments]
        prototype = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_void_p, ctypes.c_void_p, *kinds)
        self._function = prototype(self._engine.get_function_address(code.entry))
        self._results = code.signature.results
        self._result = (ctypes.c_char * RESULT_BYTES)()
        self._error = ctypes.c_void_p()
        self._counters = [
            ctypes.c_int64.from_address(self._engine.get_global_value_address(f"counter.{k}"))
            for k in range(len(self.blocks))
        ]

    def __call__(self, *arguments: Any) -> Any:
        """Runs it, and returns its result if that is one number."""
        passed = [one.ctypes.data if isinstance(one, np.ndarray) else one for one in arguments]
        failed = self._function(ctypes.addressof(self._result), ctypes.addressof(self._error), *passed)
        if failed:
            raise ArithmeticError("the kernel ended with an error")
        if len(self._results) != 1:
            return None
        return np.frombuffer(bytes(self._result), np.dtype(self._results[0].scalar), 1)[0]

    def counts(self) -> list[int]:
        """How often each block ran so far."""
        return [counter.value for counter in self._counters]


def _scalar(name: str) -> Any:
    return SCALARS.get(name, ctypes.c_int64)


def _with_counters(text: str) -> tuple[str, list[Block]]:
    """The code with counters, and its blocks in order."""
    lines: list[str] = []
    blocks: list[Block] = []
    function = ""
    wants_counter = False
    for line in text.splitlines():
        if line.startswith("define "):
            function = _name_of(line)
            blocks.append(Block(function))
            wants_counter = True
        elif function and line == "}":
            function = ""
        elif function and LABEL.match(line):
            if blocks[-1].instructions:
                blocks.append(Block(function))
            wants_counter = True
        elif function and line.strip():
            instruction = line.strip()
            if wants_counter and " = phi " not in instruction:
                lines += _counter(len(blocks) - 1)
                wants_counter = False
            blocks[-1].instructions.append(instruction)
        lines.append(line)
    lines += [f"@counter.{k} = global i64 0" for k in range(len(blocks))]
    return "\n".join(lines) + "\n", blocks


def _counter(place: int) -> list[str]:
    return [
        f"  %count.{place}.before = load i64, ptr @counter.{place}",
        f"  %count.{place}.after = add i64 %count.{place}.before, 1",
        f"  store i64 %count.{place}.after, ptr @counter.{place}",
    ]


def _name_of(line: str) -> str:
    match = re.search(r'@("[^"]+"|[\w.$-]+)\(', line)
    return match[1].strip('"') if match else "?"
