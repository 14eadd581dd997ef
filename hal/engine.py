"""The engine: the modules through which every sample goes, as machine code where somebody has built it.

Time, processor, wires, the busiest chip models, drivers and output take most of what an emulated tick costs.
They are ordinary Python and run as such; `python -m hal.engine_build` also translates them by mypyc, with
the same results bit for bit, in the groups of `hal.engine_modules`. What was built lies in the Python
environment, a folder for each group, named by a hash of its sources and the interpreter: a changed source
never hides behind old machine code, its group is interpreted until it is built anew.

`NAVTWIN_ENGINE=interpreted` takes the Python sources in any case, for debuggers and for patches of classes;
`NAVTWIN_ENGINE=emulation` takes this group alone as machine code (several: with commas).
"""

import hashlib
import importlib
import importlib.abc
import importlib.machinery
import importlib.util
import os
import sys
import sysconfig
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType

from hal.engine_modules import GROUPS

CHOICE = "NAVTWIN_ENGINE"

_ROOT = Path(__file__).resolve().parents[1]


def library(group: str) -> str:
    """The one shared library behind all modules of a group."""
    return f"navtwin_{group}__mypyc"


def sources(group: str) -> list[Path]:
    """The files that a group consists of."""
    return [_ROOT.joinpath(*name.split(".")).with_suffix(".py") for name in GROUPS[group]]


def folder(group: str) -> Path:
    """Where a group lies for its present sources and this interpreter, if anybody has built it."""
    digest = hashlib.sha256(f"{sys.version} {sysconfig.get_config_var('SOABI')}".encode())
    for name, path in zip(GROUPS[group], sources(group), strict=True):
        digest.update(name.encode() + b"\0" + path.read_bytes() + b"\0")
    return Path(sys.prefix) / "lib" / "navtwin-engine" / f"{group}-{digest.hexdigest()[:16]}"


def library_file(group: str, built: Path) -> Path:
    """The library in a group's folder."""
    return built / (library(group) + importlib.machinery.EXTENSION_SUFFIXES[0])


class MachineCode(importlib.abc.MetaPathFinder):
    """Finds modules in what `engine_build` has built; looks for a group when its first module is wanted."""

    def __init__(self) -> None:
        self._group_of = {name: group for group, names in GROUPS.items() for name in names}
        self._libraries: dict[str, Path | None] = {}

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        """Answer imports (importlib's protocol)."""
        group = self._group_of.get(fullname)
        if group is None:
            return None
        if group not in self._libraries:
            self._libraries[group] = _built(group) if _is_chosen(group) else None
        file = self._libraries[group]
        if file is None:
            return None
        loader = ModuleInLibrary(library(group), file)
        return importlib.util.spec_from_file_location(fullname, file, loader=loader)


class ModuleInLibrary(importlib.abc.Loader):
    """Loads one of the modules that a group's library holds."""

    def __init__(self, library_name: str, file: Path) -> None:
        self._name = library_name
        self._file = file

    def create_module(self, spec: importlib.machinery.ModuleSpec) -> ModuleType:
        """Made and run at once, as by a library of its own."""
        entry = f"init_{spec.name.replace('.', '___')}"
        capsule = getattr(_opened(self._name, self._file), entry)
        return _called(capsule, f"{self._name}.{entry}")

    def exec_module(self, module: ModuleType) -> None:
        """Nothing is left to do."""


def _opened(name: str, file: Path) -> ModuleType:
    """The library itself, once in a process."""
    if name not in sys.modules:
        spec = importlib.util.spec_from_file_location(name, file)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module
        spec.loader.exec_module(module)
    return sys.modules[name]


def _called(capsule: object, name: str) -> ModuleType:
    """Call the function `PyObject *(void)` that a capsule holds."""
    import ctypes

    pointer_of = ctypes.pythonapi.PyCapsule_GetPointer
    pointer_of.restype, pointer_of.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    make = ctypes.PYFUNCTYPE(ctypes.py_object)(pointer_of(capsule, name.encode()))
    module: ModuleType = make()
    return module


def _is_chosen(group: str) -> bool:
    choice = os.environ.get(CHOICE, "")
    return not choice or group in choice.split(",")


def _built(group: str) -> Path | None:
    """The library of a group for its present sources."""
    try:
        file = library_file(group, folder(group))
        file.stat()
    except OSError:  # not built, not ours to read, or there are no sources to compare with
        return None
    return file


def use() -> None:
    """From here on the groups that are built for their sources are imported as machine code."""
    if not any(type(finder) is MachineCode for finder in sys.meta_path):
        sys.meta_path.insert(0, MachineCode())


def description() -> str:
    """What of the engine this process runs as machine code so far."""
    compiled = [group for group in GROUPS if library(group) in sys.modules]
    return f"machine code ({', '.join(compiled)})" if compiled else "interpreted"
