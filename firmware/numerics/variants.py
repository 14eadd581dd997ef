"""The same kernels built another way, beside the ordinary ones in one process.

A variant is a second import of the firmware package under a name of its own (`firmware_float64.nav.strapdown`
beside `firmware.nav.strapdown`): the source files are the same, but every import of `firmware` in them leads
to the variant's modules, the decorator `kernel` is the variant's, and the source may be rewritten on the way.
So a whole tree of kernels calling each other is interpreted, in float64, or compiled for another processor,
and its tracebacks still show the real file and line.
"""

import ast
import importlib
import importlib.abc
import importlib.machinery
import importlib.util
import sys
from collections.abc import Callable, Mapping, Sequence
from types import CodeType, ModuleType
from typing import Any

from firmware.numerics.signature import Signature, parse_signature

ORIGINAL = "firmware"
DIALECT = "firmware.numerics.dialect"

Decorate = Callable[[Callable[..., Any], Signature | None], Any]


def _unchanged(tree: ast.Module) -> ast.Module:
    return tree


class KernelVariant(importlib.abc.MetaPathFinder):
    """A second import of `firmware` as `firmware_<name>`.

    decorate: makes a kernel of a function and its signature (None for inner functions).
    rewrite: changes a module's syntax tree; it may change the tree in place.
    replacements: modules whose source another module gives, by full names in `firmware`.
    kernels: after loading, every kernel made: `firmware.…` name of the original -> what `decorate` returned.

    ValueError when a variant of this name exists already.
    """

    def __init__(
        self,
        name: str,
        decorate: Decorate,
        rewrite: Callable[[ast.Module], ast.Module] = _unchanged,
        replacements: Mapping[str, str] | None = None,
    ) -> None:
        self.root = f"{ORIGINAL}_{name}"
        if any(getattr(finder, "root", None) == self.root for finder in sys.meta_path):
            raise ValueError(f"kernel variant {name!r} exists already")
        self._decorate = decorate
        self._rewrite = rewrite
        self._replacements = dict(replacements or {})
        self.kernels: dict[str, Any] = {}
        sys.meta_path.insert(0, self)

    def load(self, module: str) -> ModuleType:
        """The variant of `module`, e.g. "firmware.nav.strapdown"; ModuleNotFoundError as from `import`."""
        if module != ORIGINAL and not module.startswith(ORIGINAL + "."):
            raise ValueError(f"only firmware modules (firmware.nav.strapdown) have variants, got {module!r}")
        return importlib.import_module(self.root + module[len(ORIGINAL) :])

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        """Answer imports of `firmware_<name>` and below (importlib's protocol)."""
        if fullname != self.root and not fullname.startswith(self.root + "."):
            return None
        original = ORIGINAL + fullname[len(self.root) :]
        if original == DIALECT:
            return importlib.machinery.ModuleSpec(fullname, _DialectLoader(self))
        found = importlib.util.find_spec(self._replacements.get(original, original))
        if found is None or found.origin is None:
            return None
        loader = _RewritingLoader(fullname, found.origin, self)
        return importlib.util.spec_from_file_location(
            fullname, found.origin, loader=loader, submodule_search_locations=found.submodule_search_locations
        )

    def make_kernel(self, declaration: str | Callable[..., Any]) -> Any:
        """The variant's `@kernel`, with or without a signature."""
        if not isinstance(declaration, str):
            return self._make(declaration, None)
        signature = parse_signature(declaration)
        return lambda function: self._make(function, signature)

    def _make(self, function: Callable[..., Any], signature: Signature | None) -> Any:
        made = self._decorate(function, signature)
        original = ORIGINAL + function.__module__[len(self.root) :]
        self.kernels[f"{original}.{function.__qualname__}"] = made
        return made

    def compile_module(self, data: Any, path: str) -> CodeType:
        """Code of a source file with the variant's rewriting and imports."""
        tree = self._rewrite(_RootRenamer(self.root).visit(ast.parse(data, path)))
        return compile(ast.fix_missing_locations(tree), path, "exec", dont_inherit=True)


class _RootRenamer(ast.NodeTransformer):
    """Lead `import firmware.x` and `from firmware.x import y` to another root package."""

    def __init__(self, root: str) -> None:
        self._root = root

    def visit_ImportFrom(self, node: ast.ImportFrom) -> ast.AST:
        if node.level == 0 and node.module and _is_ours(node.module):
            node.module = self._root + node.module[len(ORIGINAL) :]
        return node

    def visit_Import(self, node: ast.Import) -> ast.AST:
        for alias in node.names:
            if _is_ours(alias.name):
                if alias.asname is None:
                    raise ImportError(
                        f"line {node.lineno}: write `from firmware.nav import layout` or "
                        f"`import {alias.name} as …` so that the module can be built in a variant"
                    )
                alias.name = self._root + alias.name[len(ORIGINAL) :]
        return node


def _is_ours(module: str) -> bool:
    return module == ORIGINAL or module.startswith(ORIGINAL + ".")


class _RewritingLoader(importlib.machinery.SourceFileLoader):
    def __init__(self, fullname: str, path: str, variant: KernelVariant) -> None:
        super().__init__(fullname, path)
        self._variant = variant

    def get_code(self, fullname: str) -> CodeType:
        return self._variant.compile_module(self.get_data(self.path), self.path)


class _DialectLoader(importlib.abc.Loader):
    """Gives the variant's modules a `firmware.numerics.dialect` that holds the variant's decorator."""

    def __init__(self, variant: KernelVariant) -> None:
        self._variant = variant

    def exec_module(self, module: ModuleType) -> None:
        module.kernel = self._variant.make_kernel  # type: ignore[attr-defined]
