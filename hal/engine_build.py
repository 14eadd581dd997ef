"""Translates the engine (`hal.engine`) to machine code: `python -m hal.engine_build`, part of `make setup`.

It needs mypy (whose mypyc translates to C) and a C compiler. Where one is missing a line says so, the engine
stays interpreted and everything works, at some two thirds of the speed. Built aside and renamed into place.
"""

import importlib.util
import os
import shutil
import sys
import tempfile
import time
from pathlib import Path

from hal import engine

PACKAGE_ROOT = Path(engine.__file__).resolve().parents[1]
BUILDS_KEPT = 4
"""Beside the new one: branches that take turns in one environment, 2 MB each."""
UNFINISHED = "being-built-"
"""How the folder of a build begins until it is whole."""
LONGEST_BUILD_S = 3600.0
"""What is still unfinished after that was interrupted."""


class NotPossibleError(Exception):
    """The engine cannot be translated here; the message says why and what would help."""


def build() -> Path:
    """The engine's folder, filled. Raises NotPossibleError; nothing is left half-done."""
    target = engine.folder()
    if target.exists():
        return target
    for module, package in (("mypyc", "mypy"), ("setuptools", "setuptools")):
        if importlib.util.find_spec(module) is None:
            raise NotPossibleError(f"{package} is not installed (pip install {package})")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        aside = Path(tempfile.mkdtemp(prefix=UNFINISHED, dir=target.parent))
    except OSError as error:
        raise NotPossibleError(f"{target.parent} cannot be written ({error.strerror})") from error
    try:
        _compile(aside)
        aside.chmod(0o755)
        _drop_older(target.parent)
        if engine.folder() != target:
            raise NotPossibleError("its sources were changed meanwhile; build it again")
        _put_in_place(aside, target)
    finally:
        shutil.rmtree(aside, ignore_errors=True)
    return target


def _put_in_place(aside: Path, target: Path) -> None:
    """Another process that built the same at the same time may have been first: that is as good."""
    try:
        aside.rename(target)
    except OSError as error:
        if not target.exists():
            raise NotPossibleError(f"{target} cannot be written ({error.strerror})") from error


def _compile(folder: Path) -> None:
    """Machine code of all modules below `folder`, C sources beside it while it works."""
    from mypyc.build import mypycify
    from setuptools import Distribution
    from setuptools.command.build_ext import build_ext
    from setuptools.errors import CCompilerError, ExecError, PlatformError

    before = Path.cwd()
    os.chdir(PACKAGE_ROOT)
    try:
        with tempfile.TemporaryDirectory(dir=folder) as scratch:
            paths = [str(path.relative_to(PACKAGE_ROOT)) for path in engine.sources()]
            name = engine.LIBRARY.removesuffix("__mypyc")
            extensions = mypycify(paths, target_dir=scratch, opt_level="2", debug_level="0", group_name=name)
            command = build_ext(Distribution({"name": name, "ext_modules": extensions}))
            command.build_lib, command.build_temp = str(folder), scratch
            command.ensure_finalized()
            command.run()
    except SystemExit as error:  # what mypyc has to say stands on the terminal already
        raise NotPossibleError("mypyc does not translate these sources") from error
    except OSError as error:
        raise NotPossibleError(f"{folder} cannot be filled ({error.strerror})") from error
    except (CCompilerError, ExecError, PlatformError) as error:
        raise NotPossibleError(
            f"no C compiler that works with this Python (Debian: apt install gcc python3-dev; {error})"
        ) from error
    finally:
        os.chdir(before)


def _drop_older(parent: Path) -> None:
    """All but the last builds of this environment, and what interrupted builds have left; a process that has
    a dropped one open keeps it."""
    ages = {folder: time.time() - folder.stat().st_mtime for folder in parent.iterdir()}
    unfinished = [folder for folder in ages if folder.name.startswith(UNFINISHED)]
    built = sorted(ages.keys() - set(unfinished), key=ages.__getitem__)
    interrupted = [folder for folder in unfinished if ages[folder] > LONGEST_BUILD_S]
    for folder in [*built[BUILDS_KEPT:], *interrupted]:
        shutil.rmtree(folder, ignore_errors=True)


def main() -> None:
    """Build, and say what came of it in one line."""
    if engine.folder().exists():
        return
    print("navtwin: translating the emulator's engine to machine code …", flush=True)
    started = time.monotonic()
    try:
        build()
    except NotPossibleError as error:
        print(f"navtwin: the engine stays interpreted: {error}", file=sys.stderr)
    else:
        print(f"navtwin: engine built in {time.monotonic() - started:.0f} s")


if __name__ == "__main__":
    main()
