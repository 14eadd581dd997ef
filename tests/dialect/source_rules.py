"""The rules of the kernel dialect that can be read off the source, each with the place and the right form.

`violations(functions)` looks at plain Python functions (what stands under `@kernel`), with the values that
their global names have, so that `N` in `x // N` is known to be a constant and `rotate(…)` to be a kernel.
What only types can tell (float32 × int, a float64 global through a tuple) is left to the compiled code.
"""

import ast
import inspect
import math
import textwrap
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from types import FunctionType, ModuleType
from typing import Any

import numpy as np

Function = Callable[..., Any]

SCALAR_TYPES = {
    np.float32, np.int8, np.int16, np.int32, np.int64, np.uint8, np.uint16, np.uint32, np.uint64
}  # fmt: skip
WRAPPED_MATH = {math.sqrt, math.copysign}
PLAIN_MATH = {math.isnan, math.isinf, math.isfinite}
ALLOWED_BUILTINS = {abs, min, max, range, bool, ord}

# What a construct is called, and what to write instead.
FORBIDDEN_NODES: dict[type[ast.AST], tuple[str, str]] = {
    ast.List: ("list", "pass a flat array in"),
    ast.ListComp: ("list", "pass a flat array in"),
    ast.GeneratorExp: ("generator", "write the loop"),
    ast.Dict: ("dict", "use index constants into a flat array"),
    ast.DictComp: ("dict", "use index constants into a flat array"),
    ast.Set: ("set", "compare one by one"),
    ast.SetComp: ("set", "compare one by one"),
    ast.JoinedStr: ("text", "kernels have numbers only"),
    ast.Try: ("exception", "return a result that says so"),
    ast.Raise: ("exception", "return a result that says so"),
    ast.Assert: ("exception", "return a result that says so"),
    ast.With: ("with", "kernels hold no resources"),
    ast.Lambda: ("inner function", "write a kernel of its own"),
    ast.FunctionDef: ("inner function", "write a kernel of its own"),
    ast.ClassDef: ("class", "use index constants into a flat array"),
    ast.Import: ("import", "import at the top of the module"),
    ast.ImportFrom: ("import", "import at the top of the module"),
    ast.Global: ("global", "state lives in the arrays passed in"),
    ast.Yield: ("generator", "write the loop"),
    ast.Starred: ("starred argument", "name the elements"),
}
ADVICE_FOR_CALLS = {
    "print": "kernels do not print",
    "round": "x + copysign(HALF, x), then np.int32(...)",
    "int": "np.int32(...) or np.int64(...)",
    "float": "np.float32(...)",
    "len": "an index constant: on the target an array is a bare pointer",
    "pow": "multiply",
    "sum": "write the loop",
    "zip": "loop over range(np.int32(N))",
    "enumerate": "loop over range(np.int32(N))",
}


@dataclass(frozen=True, slots=True)
class Violation:
    """One breach: where, which rule, the offending text, what to write."""

    file: str
    line: int
    rule: str
    text: str
    advice: str

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: {self.rule}: `{self.text}`; write instead: {self.advice}"


def violations(functions: Iterable[Function], all_kernels: Iterable[Any]) -> list[Violation]:
    """Breaches in the sources of `functions`; `all_kernels` are the objects that may be called."""
    callable_kernels = {id(kernel) for kernel in all_kernels}
    found: list[Violation] = []
    calls: dict[Function, list[tuple[Function, ast.Call]]] = {}
    for function in functions:
        source = _KernelSource(function, callable_kernels)
        found += source.check()
        calls[function] = source.kernel_calls
    found += _recursions(calls)
    return sorted(set(found), key=lambda violation: (violation.file, violation.line, violation.rule))


def _plain(kernel: Any) -> Function:
    return getattr(kernel, "py_func", kernel)


def _recursions(calls: Mapping[Function, list[tuple[Function, ast.Call]]]) -> Iterator[Violation]:
    for start in calls:
        reached, waiting = set(), [start]
        while waiting:
            for callee, node in calls.get(waiting.pop(), []):
                if callee is start:
                    yield _violation(start, node, "recursion", "a loop, with what is left to do in an array")
                elif callee not in reached:
                    reached.add(callee)
                    waiting.append(callee)


def _violation(function: Function, node: ast.AST, rule: str, advice: str) -> Violation:
    line = function.__code__.co_firstlineno + getattr(node, "lineno", 1) - 1
    text = ast.unparse(node).splitlines()[0]
    return Violation(function.__code__.co_filename, line, rule, text, advice)


class _KernelSource:
    """One kernel's syntax tree and the values of its names."""

    def __init__(self, function: Function, callable_kernels: set[int]) -> None:
        self.function = function
        self.kernel_calls: list[tuple[Function, ast.Call]] = []
        self._callable_kernels = callable_kernels
        tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
        definition = tree.body[0]
        assert isinstance(definition, ast.FunctionDef)
        self._definition = definition
        self._locals = {argument.arg for argument in definition.args.args}
        self._locals |= {
            node.id
            for node in ast.walk(definition)
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
        }
        self._found: list[Violation] = []

    def check(self) -> list[Violation]:
        parameters = self._definition.args
        if parameters.defaults or parameters.vararg or parameters.kwonlyargs or parameters.kwarg:
            self._report(self._definition, "parameters", "plain positional parameters without defaults")
        body = self._definition.body
        if isinstance(body[0], ast.Expr) and isinstance(body[0].value, ast.Constant):
            body = body[1:]  # the docstring
        for statement in body:
            self._visit(statement, parent=None)
        return self._found

    def _report(self, node: ast.AST, rule: str, advice: str) -> None:
        self._found.append(_violation(self.function, node, rule, advice))

    def _visit(self, node: ast.AST, parent: ast.AST | None) -> None:
        forbidden = FORBIDDEN_NODES.get(type(node))
        if forbidden is not None:
            self._report(node, *forbidden)
            return
        if isinstance(node, ast.Constant):
            self._check_constant(node)
        elif isinstance(node, ast.Name):
            self._check_name(node)
        elif isinstance(node, ast.BinOp):
            self._check_operator(node, node.op, node.right)
        elif isinstance(node, ast.AugAssign):
            self._check_operator(node, node.op, node.value)
        elif isinstance(node, ast.Subscript):
            self._check_index(node)
        elif isinstance(node, ast.Call):
            self._check_call(node, parent)
            if self._value(node.func) is ord and isinstance(node.args[0], ast.Constant):
                return
        for child in ast.iter_child_nodes(node):
            self._visit(child, node)

    def _value(self, node: ast.AST) -> Any:
        """What a name or a dotted name of the module stands for; None for locals and unknown names."""
        if isinstance(node, ast.Name) and node.id not in self._locals:
            names = self.function.__globals__
            builtins = names.get("__builtins__", {})
            builtins = vars(builtins) if isinstance(builtins, ModuleType) else builtins
            return names.get(node.id, builtins.get(node.id))
        if isinstance(node, ast.Attribute):
            owner = self._value(node.value)
            return getattr(owner, node.attr, None) if isinstance(owner, ModuleType) else None
        return None

    def _check_constant(self, node: ast.Constant) -> None:
        if isinstance(node.value, float | complex):
            name = f"SOME_NAME = np.float32({node.value})"
            self._report(node, "float literal", f"a module constant, {name}")
        elif isinstance(node.value, str | bytes):
            self._report(node, "text", "kernels have numbers only")

    def _check_name(self, node: ast.Name) -> None:
        value = self._value(node)
        if isinstance(value, float):  # np.float64 is one too
            self._report(node, "float64 constant", f"{node.id} = np.float32(...) where it is defined")
        elif isinstance(value, list | dict | set | np.ndarray):
            self._report(node, "global container", "pass a flat array in, or a tuple of np.float32 constants")

    def _check_operator(self, node: ast.AST, operator: ast.operator, right: ast.AST) -> None:
        if isinstance(operator, ast.Pow):
            self._report(node, "power", "x * x")
        elif isinstance(operator, ast.MatMult):
            self._report(node, "matrix product", "write the loops, p[i * N + j]")
        elif isinstance(operator, ast.FloorDiv | ast.Mod) and not self._is_constant_integer(right):
            sign = "//" if isinstance(operator, ast.FloorDiv) else "%"
            self._report(node, f"{sign} by a variable", "divide by a constant, shift or mask")

    def _is_constant_integer(self, node: ast.AST) -> bool:
        if isinstance(node, ast.Call) and self._value(node.func) in SCALAR_TYPES and len(node.args) == 1:
            return self._is_constant_integer(node.args[0])
        value = node.value if isinstance(node, ast.Constant) else self._value(node)
        return isinstance(value, int | np.integer)

    def _check_index(self, node: ast.Subscript) -> None:
        if isinstance(node.slice, ast.Tuple):
            self._report(node, "two-dimensional index", "a flat array, p[i * N + j]")
        elif any(isinstance(part, ast.Slice) for part in ast.walk(node.slice)):
            self._report(node, "slice", "pass the array and an offset")
        elif isinstance(node.slice, ast.UnaryOp) and isinstance(node.slice.op, ast.USub):
            self._report(node, "negative index", "an index from the start: the target has no length")

    def _check_call(self, node: ast.Call, parent: ast.AST | None) -> None:
        if node.keywords:
            self._report(node, "keyword argument", "positional arguments")
        if isinstance(node.func, ast.Attribute) and node.func.attr == "view" and len(node.args) == 1:
            return
        called = self._value(node.func)
        if called is range:
            for argument in node.args:
                self._check_range(argument)
        elif id(called) in self._callable_kernels:
            self.kernel_calls.append((_plain(called), node))
        elif _is_in(called, WRAPPED_MATH):
            if not (isinstance(parent, ast.Call) and self._value(parent.func) is np.float32):
                self._report(node, "unwrapped math", f"np.float32({ast.unparse(node)})")
        elif not (
            _is_in(called, SCALAR_TYPES) or _is_in(called, PLAIN_MATH) or _is_in(called, ALLOWED_BUILTINS)
        ):
            self._report_call(node, called)

    def _report_call(self, node: ast.Call, called: Any) -> None:
        name = ast.unparse(node.func)
        if getattr(called, "__module__", None) == "math" or name.startswith("math."):
            self._report(node, "C library", "the functions of firmware.numerics.trigonometry, or arithmetic")
        elif name.startswith("np."):
            self._report(node, "NumPy function", "loops over flat arrays that are passed in")
        elif isinstance(called, FunctionType):
            self._report(node, "call of a plain function", f"@kernel above the definition of {name}")
        else:
            self._report(node, "call", ADVICE_FOR_CALLS.get(name, "a kernel, np.int32(...), abs, min or max"))

    def _check_range(self, argument: ast.AST) -> None:
        if isinstance(argument, ast.UnaryOp) and isinstance(argument.op, ast.USub):
            argument = argument.operand
        is_number = isinstance(argument, ast.Constant | ast.BinOp)  # numba makes every sum of int32 an int64
        wide_name = isinstance(argument, ast.Name | ast.Attribute) and self._value(argument) is not None
        if is_number or (wide_name and not isinstance(self._value(argument), np.int32)):
            self._report(argument, "64-bit loop", f"range(np.int32({ast.unparse(argument)}))")


def _is_in(value: Any, known: set[Any]) -> bool:
    return any(value is one for one in known)
