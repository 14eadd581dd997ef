"""How numba compiles kernels: a short way to machine code, and none for what ends inside other kernels.

Ordinarily numba optimises every function, makes machine code of it and a wrapper for Python, and optimises it
again wherever it is linked into a caller. A kernel that other kernels call ends inside of them, so here it
stays LLVM's intermediate code: it is optimised and becomes machine code once, with the entry kernel that
Python calls. And numba's passes for what the dialect does not have (closures, `with`, exceptions, literal
unrolling, array expressions) are left out. So the first compilation of all kernels takes much less time, and
the code that runs is the same.

Made by numba's documented means to customise a compiler (`pipeline_class`) and by a code library of its own.
"""

import functools
import importlib
import sys
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numba
from numba.core import typed_passes, types, untyped_passes
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, Flags
from numba.core.compiler_machinery import PassManager, register_pass
from numba.core.typing import Context


def _never_load_blas() -> None:
    """Let numba find no linear algebra when it looks for it: no kernel uses it, loading takes 0.3 s."""
    if "scipy.linalg" in sys.modules:
        return
    sys.modules["scipy.linalg"] = None  # type: ignore[assignment]
    try:
        importlib.import_module("numba.np.arraymath")
    finally:
        del sys.modules["scipy.linalg"]


_never_load_blas()


class InnerLibrary(JITCodeLibrary):
    """Intermediate code of one kernel and of those it calls, to be linked into another library."""

    def _finalize_final_module(self) -> None:
        """No machine code."""
        self._finalize_dynamic_globals()
        self._finalized = True


class RawInnerLibrary(InnerLibrary):
    """The same, to be optimised only there."""

    def _optimize_final_module(self) -> None:
        """Left to the library that this one is linked into."""


@register_pass(mutates_CFG=True, analysis_only=False)
class InnerLowering(typed_passes.NativeLowering):
    """Numba's lowering into an `InnerLibrary`, without anything that Python could call."""

    _name = "inner_lowering"

    def run_pass(self, state: Any) -> bool:
        """Lower the kernel and make it known to those that call it."""
        # Code that is inlined by force is not optimised first, as the inliner does on its own.
        kind = InnerLibrary if state.flags.forceinline else RawInnerLibrary
        state.library = kind(state.targetctx.codegen(), state.func_id.func_qualname)
        state.flags.no_compile = state.flags.no_cpython_wrapper = True
        super().run_pass(state)
        lowered = state["cr"]
        name_of_its_own = object()  # numba finds a callee's code by the identity of its function
        state.targetctx.insert_user_function(name_of_its_own, lowered.fndesc, [state.library])
        state["cr"] = lowered._replace(cfunc=name_of_its_own)
        return True


class QuickFlags(Flags):
    """Numba's options of a compilation; they are compared whenever the type of an operation is looked up."""

    _DEFAULTS: ClassVar = {name: option.default for name, option in Flags.options.items()}

    def values(self) -> dict[str, Any]:
        """All options."""
        return self._DEFAULTS | self._values

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Flags) and self.values() == other.values()

    def __hash__(self) -> int:
        return 1


class RememberingContext(Context):
    """Numba's knowledge of types, which looks up the rules for an operation only once."""

    def __init__(self, original: Context) -> None:
        self.__dict__ = original.__dict__  # it stays one with numba's own
        self._found: dict[Any, Any] = self.__dict__.setdefault("_found_by_kernels", {})

    def resolve_function_type(self, func: Any, args: Any, kws: Any) -> Any:
        """The signature of an operation, a function or another kernel for argument types."""
        if kws or isinstance(func, str | types.Dispatcher):
            return super().resolve_function_type(func, args, kws)
        key = (func, tuple(args))
        found = self._found.get(key)
        if found is None:
            found = self._found[key] = super().resolve_function_type(func, args, kws)
        return found


_remembering = functools.cache(RememberingContext)


class KernelCompiler(CompilerBase):
    """Numba's compiler with the passes that the dialect needs."""

    LOWERING = typed_passes.NativeLowering

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.state.flags = QuickFlags(self.state.flags)
        self.state.typingctx = _remembering(self.state.typingctx)

    def define_pipelines(self) -> list[PassManager]:
        """One pipeline, from Python's byte code to LLVM."""
        passes = (
            (untyped_passes.TranslateByteCode, "analyse byte code"),
            (untyped_passes.FixupArgs, "number arguments"),
            (untyped_passes.IRProcessing, "process intermediate code"),
            (untyped_passes.RewriteSemanticConstants, "rewrite constants"),
            (untyped_passes.DeadBranchPrune, "prune dead branches"),
            (untyped_passes.GenericRewrites, "rewrite constant indices"),
            (untyped_passes.ReconstructSSA, "single assignment"),
            (typed_passes.NopythonTypeInference, "infer types"),
            (typed_passes.PreLowerStripPhis, "remove phi nodes"),
            (typed_passes.NoPythonSupportedFeatureValidation, "check features"),
            (typed_passes.IRLegalization, "legalise"),
            (typed_passes.AnnotateTypes, "annotate types"),
            (self.LOWERING, "lower"),
            (typed_passes.NoPythonBackend, "finish"),
        )
        pipeline = PassManager("kernel")
        for kind, description in passes:
            pipeline.add_pass(kind, description)
        pipeline.finalize()
        return [pipeline]


class InnerCompiler(KernelCompiler):
    """The same for a kernel that other kernels call."""

    LOWERING = InnerLowering


def make_inner(function: Callable[..., Any], options: Mapping[str, Any]) -> Any:
    """A dispatcher of numba for the calls of other kernels; Python cannot call it."""
    dispatcher: Any = numba.njit(pipeline_class=InnerCompiler, **options)(function)

    def add_overload(result: Any) -> None:
        dispatcher.overloads[tuple(result.signature.args)] = result

    dispatcher.add_overload = add_overload
    return dispatcher


def let_kernels_call(dispatcher: Any, make: Callable[[], Any]) -> None:
    """Give kernels that call `dispatcher` the code of its inner form, which `make` makes when first asked."""

    @functools.cache
    def inner() -> Any:
        dispatcher.inner = made = make()
        return made

    dispatcher.get_call_template = lambda *arguments: inner().get_call_template(*arguments)
    dispatcher.get_overload = lambda signature: inner().get_overload(signature)
