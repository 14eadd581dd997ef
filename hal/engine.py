"""The engine: the modules of `hal.emulated` through which every sample goes, as machine code where built.

Time, processor, interrupt lines, pins and SPI take most of what an emulated tick costs. They are ordinary
Python and run as such; `python -m hal.engine_build` also translates them by mypyc, with the same results bit
for bit. What was built lies in the Python environment, in a folder named by a hash of the sources and the
interpreter: a changed source never hides behind old machine code, it is interpreted until it is built anew.

`NAVTWIN_ENGINE=interpreted` takes the Python sources in any case, for debuggers and for patches of classes.
"""

import hashlib
import importlib.machinery
import importlib.util
import os
import sys
import sysconfig
from pathlib import Path

PACKAGE = "hal.emulated"
MODULES = ("virtual_time", "interrupt_line", "cpu", "pins", "spi", "timers")
"""Of PACKAGE, to be translated together."""
LIBRARY = "navtwin_engine__mypyc"
"""The one shared library behind all of them."""
CHOICE = "NAVTWIN_ENGINE"

_SOURCES = Path(__file__).resolve().parent / "emulated"


def sources() -> list[Path]:
    """The files that the engine consists of."""
    return [_SOURCES / f"{name}.py" for name in MODULES]


def folder() -> Path:
    """Where the engine lies for the present sources and this interpreter, if anybody has built it."""
    digest = hashlib.sha256(f"{sys.version} {sysconfig.get_config_var('SOABI')}".encode())
    for path in sources():
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return Path(sys.prefix) / "lib" / "navtwin-engine" / digest.hexdigest()[:16]


def attach(search_path: list[str]) -> None:
    """Put machine code before the sources on the search path of PACKAGE, if there is some for them."""
    if os.environ.get(CHOICE, "") == "interpreted":
        return
    built = folder()
    library = built / (LIBRARY + importlib.machinery.EXTENSION_SUFFIXES[0])
    if not library.exists():
        return
    spec = importlib.util.spec_from_file_location(LIBRARY, library)
    if spec is None or spec.loader is None:
        return
    sys.modules[LIBRARY] = importlib.util.module_from_spec(spec)
    search_path.insert(0, str(built.joinpath(*PACKAGE.split("."))))


def is_compiled() -> bool:
    """Whether this process runs the engine as machine code."""
    return LIBRARY in sys.modules
