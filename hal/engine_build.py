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


class NotPossibleError(Exception):
    """The engine cannot be translated here; the message says why and what would help."""


def build() -> Path:
    """The engine's folder, filled. Raises NotPossibleError; nothing is left half-done."""
    target = engine.folder()
    if target.exists():
        return target
    if importlib.util.find_spec("mypyc") is None:
        raise NotPossibleError("mypy is not installed (pip install 'navtwin[dev]')")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        aside = Path(tempfile.mkdtemp(prefix="being-built-", dir=target.parent))
    except OSError as error:
        raise NotPossibleError(f"{target.parent} cannot be written ({error.strerror})") from error
    try:
        _compile(aside)
        _drop_older(target.parent, aside)
        aside.rename(target)
    finally:
        shutil.rmtree(aside, ignore_errors=True)
    return target


def _compile(folder: Path) -> None:
    """Machine code of all modules below `folder`, C sources beside it while it works."""
    from mypyc.build import mypycify
    from setuptools import Distribution
    from setuptools.command.build_ext import build_ext
    from setuptools.errors import CCompilerError, ExecError, PlatformError

    before = Path.cwd()
    os.chdir(PACKAGE_ROOT)
    try:
        with tempfile.TemporaryDirectory() as scratch:
            paths = [str(path.relative_to(PACKAGE_ROOT)) for path in engine.sources()]
            name = engine.LIBRARY.removesuffix("__mypyc")
            extensions = mypycify(paths, target_dir=scratch, opt_level="2", group_name=name)
            command = build_ext(Distribution({"name": name, "ext_modules": extensions}))
            command.build_lib, command.build_temp = str(folder), scratch
            command.ensure_finalized()
            command.run()
    except (CCompilerError, ExecError, PlatformError) as error:
        raise NotPossibleError(
            f"no C compiler that works with this Python (Debian: apt install gcc python3-dev; {error})"
        ) from error
    finally:
        os.chdir(before)


def _drop_older(parent: Path, but: Path) -> None:
    """All but the last builds of this environment; a process that has a dropped one open keeps it."""
    built = sorted(parent.iterdir(), key=lambda folder: folder.stat().st_mtime, reverse=True)
    for folder in [folder for folder in built if folder != but][BUILDS_KEPT:]:
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
