"""The engine: the modules through which every sample goes, as machine code where somebody has built it.

Time, processor, interrupt lines, pins, wires and the busiest chip models take most of what an emulated tick
costs. They are ordinary Python and run as such; `python -m hal.engine_build` also translates them by mypyc,
with the same results bit for bit. What was built lies in the Python environment, in a folder named by a hash
of the sources and the interpreter: a changed source never hides behind old machine code, the whole engine is
interpreted until it is built anew.

`NAVTWIN_ENGINE=interpreted` takes the Python sources in any case, for debuggers and for patches of classes.
"""

import hashlib
import importlib.abc
import importlib.machinery
import importlib.util
import os
import sys
import sysconfig
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType

MODULES = (
    "hal.emulated.virtual_time",
    "hal.emulated.interrupt_line",
    "hal.emulated.cpu",
    "hal.emulated.pins",
    "hal.emulated.spi",
    "hal.emulated.timers",
    "hal.emulated.dual_port",
    "hal.emulated.alarm",
    "hal.emulated.uart_receiver",
    "hal.emulated.uart_wire",
    "hal.emulated.uart",
    "boards.chips.bmi160.bus_side",
    "boards.chips.bmi160.chip",
    "boards.chips.adxl345.fifo_lane",
    "boards.chips.adxl345.bus_side",
    "boards.chips.adxl345.chip",
)
"""Translated together."""
LIBRARY = "navtwin_engine__mypyc"
"""The one shared library behind all of them."""
CHOICE = "NAVTWIN_ENGINE"

_ROOT = Path(__file__).resolve().parents[1]


def sources() -> list[Path]:
    """The files that the engine consists of."""
    return [_ROOT.joinpath(*name.split(".")).with_suffix(".py") for name in MODULES]


def folder() -> Path:
    """Where the engine lies for the present sources and this interpreter, if anybody has built it."""
    digest = hashlib.sha256(f"{sys.version} {sysconfig.get_config_var('SOABI')}".encode())
    for name, path in zip(MODULES, sources(), strict=True):
        digest.update(name.encode() + b"\0" + path.read_bytes() + b"\0")
    return Path(sys.prefix) / "lib" / "navtwin-engine" / digest.hexdigest()[:16]


class MachineCode(importlib.abc.MetaPathFinder):
    """Finds the engine's modules in `folder`, where `engine_build` has put them."""

    def __init__(self, built: Path) -> None:
        self._built = built

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        """Answer imports (importlib's protocol)."""
        if fullname not in MODULES and fullname != LIBRARY:
            return None
        stem = self._built.joinpath(*fullname.split("."))
        return importlib.util.spec_from_file_location(fullname, f"{stem}{_suffix()}")


def _suffix() -> str:
    return importlib.machinery.EXTENSION_SUFFIXES[0]


def use() -> None:
    """From here on the engine's modules are imported as machine code, if there is some for their sources."""
    if os.environ.get(CHOICE, "") == "interpreted" or any(type(f) is MachineCode for f in sys.meta_path):
        return
    try:
        built = folder()
        (built / (LIBRARY + _suffix())).stat()
    except OSError:  # not built, not ours to read, or there are no sources to compare with
        return
    sys.meta_path.insert(0, MachineCode(built))


def is_compiled() -> bool:
    """Whether this process runs the engine as machine code."""
    return LIBRARY in sys.modules
