"""The decorator of all on-board arithmetic: one source, interpreted, compiled for the PC or for a Cortex-M4F.

    from firmware.numerics.dialect import kernel

    @kernel("float32(float32, float32)")
    def hypotenuse(x, y):
        return np.float32(math.sqrt(x * x + y * y))

`@kernel("signature")` compiles the function by numba at its first call, for that one signature (numba's own
notation, see `signature`), with the semantics of C without fast-math; scalars are converted on entry, arrays
must be 1-d, contiguous and of the type told. `@kernel` alone is for small functions that only other kernels
call: they take the types of the caller, are compiled into it, and are not kept between runs by themselves.

With NUMBA_DISABLE_JIT=1 the same functions run interpreted, on the same types, without importing numba; a
scalar then comes back as a NumPy scalar, whereas compiled kernels give Python numbers. Overflow, division by
zero and NaN are silent in both, as on the target.

The rules of what may stand in the body are in docs/kernel-dialect.md; the tests in tests/dialect hold them
for every function decorated here.
"""

import contextlib
import functools
import os
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar, overload

import numpy as np

from firmware.numerics.cache_folder import hash_of_folder_outside, kernel_cache_folder
from firmware.numerics.signature import Signature, parse_signature

F = TypeVar("F", bound=Callable[..., Any])

INTERPRETED = os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0")


@dataclass(frozen=True, slots=True)
class Kernel:
    """One registered kernel: the plain function, what stands under its name, its signature if it has one."""

    function: Callable[..., Any]
    callable: Callable[..., Any]
    signature: Signature | None

    @property
    def name(self) -> str:
        """Module and function, `firmware.nav.strapdown.imu_step`."""
        return f"{self.function.__module__}.{self.function.__qualname__}"

    @property
    def file(self) -> Path:
        """Source file of the function."""
        return Path(self.function.__code__.co_filename)


_registry: dict[str, Kernel] = {}


def registered_kernels() -> tuple[Kernel, ...]:
    """All kernels of the modules imported so far, by name."""
    return tuple(_registry[name] for name in sorted(_registry))


@overload
def kernel(declaration: str) -> Callable[[F], F]: ...
@overload
def kernel(declaration: F) -> F: ...
def kernel(declaration: str | F) -> Callable[[F], F] | F:
    """Make a function a kernel: `@kernel("void(float32[::1], int64)")`, or `@kernel` for inner functions.

    ValueError when the signature is not well formed or does not fit the number of parameters.
    """
    if not isinstance(declaration, str):
        return _make(declaration, None)
    signature = parse_signature(declaration)
    return lambda function: _make(function, signature)


def _make(function: F, signature: Signature | None) -> F:
    parameters = function.__code__.co_argcount
    if signature is not None and len(signature.arguments) != parameters:
        raise ValueError(
            f"kernel {function.__qualname__} takes {parameters} arguments, its signature "
            f"{signature.text!r} names {len(signature.arguments)}"
        )
    made = interpret(function, signature) if INTERPRETED else compile_lazily(function, signature)
    entry = Kernel(function, made, signature)
    _registry[entry.name] = entry
    return made


def interpret(function: F, signature: Signature | None) -> F:
    """`function` as CPython runs it, with the argument and result conversions of the compiled kernel."""

    @functools.wraps(function)
    def run(*arguments: Any) -> Any:
        with np.errstate(all="ignore"):
            if signature is None:
                return function(*arguments)
            pairs = zip(signature.arguments, arguments, strict=True)
            result = function(*[expected.convert(value) for expected, value in pairs])
            return signature.convert_result(result)

    run.py_func = function  # type: ignore[attr-defined]
    return run  # type: ignore[return-value]


def compile_lazily(function: F, signature: Signature | None, kept_as: str | None = "float32") -> F:
    """`function` as numba compiles it, at the first call from Python or from another kernel.

    Its code is kept between runs in a folder for the sources and `kept_as`; not at all for None.
    """
    import numba

    from firmware.numerics.inner_code import KernelCompiler, let_kernels_call, make_inner

    # The wrapper for C function pointers is never used; without it compilation is 8 % faster. Kernels make no
    # arrays, so that array arguments need no reference counts: a call with two of them takes half the time.
    options: dict[str, Any] = {"error_model": "numpy", "boundscheck": False, "fastmath": False}
    options |= {"no_cfunc_wrapper": True, "_nrt": False}
    folder = None
    source = Path(function.__code__.co_filename)
    if signature is not None and kept_as is not None and source.is_file():
        folder = _cache_folder(kept_as, hash_of_folder_outside(source.resolve()))
    config: Any = numba.config
    # Numba decides where a function's code is kept when it is decorated; other users of numba in this
    # process keep their own place.
    before, config.CACHE_DIR = config.CACHE_DIR, str(folder)
    try:
        entry = numba.njit(cache=folder is not None, pipeline_class=KernelCompiler, **options)
        dispatcher: Any = entry(function)
    finally:
        config.CACHE_DIR = before

    def inner_form() -> Any:
        inner = make_inner(function, options)
        if signature is None:
            compile_once_for_all_literals(inner)
        else:
            declare_only(inner, signature.text)
        return inner

    if signature is not None:
        declare_only(dispatcher, signature.text)
        _check_first_call(dispatcher, signature)
    let_kernels_call(dispatcher, inner_form)
    return dispatcher


def entry_point(kernel: F) -> F:
    """The machine code of a kernel with a signature, compiled now: calls skip numba's dispatch by types,
    about 0.25 µs each. Interpreted, the kernel itself; likewise while `entries_named` listens. While
    `entries_observed` is on, what its observer makes of it.
    """
    if _named is not None and hasattr(kernel, "compile_declared"):
        _named.append(kernel)
        return kernel
    entry: Any = kernel
    if hasattr(kernel, "compile_declared"):
        kernel.compile_declared()
        entry = next(iter(kernel.overloads.values())).entry_point  # type: ignore[attr-defined]
    return entry if _observer is None else _observer(kernel, entry)


_named: list[Any] | None = None
_observer: Callable[[Any, Any], Any] | None = None


@contextlib.contextmanager
def entries_observed(observer: Callable[[Any, Any], Any]) -> Iterator[None]:
    """Within it `entry_point` gives `observer(kernel, machine code)`: what is called in its place."""
    global _observer
    before, _observer = _observer, observer
    try:
        yield
    finally:
        _observer = before


@contextlib.contextmanager
def entries_named() -> Iterator[list[Any]]:
    """Within it `entry_point` compiles nothing; the list holds the kernels that it was asked for."""
    global _named
    before, _named = _named, []
    try:
        yield _named
    finally:
        _named = before


def kept_file(kernel: Any) -> Path | None:
    """The file that says which code of a kernel with a signature is kept; it exists when there is some.
    None when nothing is kept.
    """
    file = getattr(kernel._cache, "_cache_file", None)
    return None if file is None else Path(file._index_path)


def compiled_forms(kernel: Any) -> list[Any]:
    """Numba's results for a kernel in this process: as an entry that Python calls, and inside of others."""
    inner = getattr(kernel, "inner", None)
    return [*kernel.overloads.values(), *(inner.overloads.values() if inner is not None else ())]


def compile_once_for_all_literals(dispatcher: Any) -> None:
    """Let calls of a kernel without signature differ by types only.

    Numba would compile it anew for each integer literal passed to it, 23 times for a parser's `decimal`.
    """
    from numba.core import types

    def call_from_kernel(arguments: Any, keywords: Any) -> Any:
        plain = tuple(types.unliteral(argument) for argument in arguments)
        return type(dispatcher).get_call_template(dispatcher, plain, keywords)

    dispatcher.get_call_template = call_from_kernel


def declare_only(dispatcher: Any, signature_text: str) -> None:
    """Let numba's `dispatcher` compile the declared signature when another kernel needs it, and nothing else.

    `dispatcher.compile_declared()` does it at once.
    """
    from numba.core.compiler_lock import global_compiler_lock

    def compile_declared() -> None:
        with global_compiler_lock:
            if dispatcher._can_compile:
                dispatcher._compilation_chain_init_hook()
                dispatcher.compile(signature_text)
                dispatcher.disable_compile()

    def call_from_kernel(arguments: Any, keywords: Any) -> Any:
        compile_declared()
        return type(dispatcher).get_call_template(dispatcher, arguments, keywords)

    dispatcher.compile_declared = compile_declared
    dispatcher.get_call_template = call_from_kernel


def _check_first_call(dispatcher: Any, signature: Signature) -> None:
    """Compile at the first call from Python; arrays of that call must be right, numba checks later ones."""

    def first_call(*arguments: Any) -> Any:
        for expected, value in zip(signature.arguments, arguments, strict=True):
            if expected.is_array:
                expected.convert(value)
        dispatcher.compile_declared()
        return next(iter(dispatcher.overloads.values())).entry_point

    dispatcher._compile_for_args = first_call


@functools.cache
def _cache_folder(kept_as: str, hash_outside: str) -> Path | None:
    import llvmlite.binding
    import numba

    config: Any = numba.config
    processor = llvmlite.binding.get_host_cpu_name()
    versions = (sys.version, numba.__version__, np.__version__, processor, config.OPT, kept_as, hash_outside)
    return kernel_cache_folder(repr(versions))
