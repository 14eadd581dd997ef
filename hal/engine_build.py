"""Translates the engine (`hal.engine`) to machine code: `python -m hal.engine_build`, part of `make setup`.

It needs mypy (whose mypyc translates to C) and a C compiler. Where one is missing a line says so, the engine
stays interpreted and everything works, at some two thirds of the speed. Built aside and renamed into place.
"""

import contextlib
import importlib.util
import io
import os
import shutil
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from hal import engine
from hal.engine_modules import GROUPS

PACKAGE_ROOT = Path(engine.__file__).resolve().parents[1]
BUILDS_KEPT = 4
"""Of a group, beside the new one: branches that take turns in one environment, 1 MB each."""
UNFINISHED = "being-built-"
"""How the folder of a build begins until it is whole."""
LONGEST_BUILD_S = 3600.0
"""What is still unfinished after that was interrupted."""
OPTIMISATION = "1"
"""Of the C compiler: half the time of 2, and code as fast, which waits for memory more than it computes."""
TYPES = """[mypy]
ignore_errors = True
[mypy-numpy.*,greenlet.*,numba.*,llvmlite.*]
follow_imports = skip
ignore_missing_imports = True
"""
"""What is known of others' packages does not change the C code; to read it takes two thirds of the time.
Errors of types are for `mypy` with its own settings: without those packages some are found that are none."""


class NotPossibleError(Exception):
    """The engine cannot be translated here; the message says why and what would help."""


def build(group: str) -> Path:
    """A group's folder, filled. Raises NotPossibleError; nothing is left half-done."""
    target = engine.folder(group)
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
        _compile(group, aside)
        aside.chmod(0o755)
        _drop_older(target.parent, group)
        if engine.folder(group) != target:
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


def _compile(group: str, folder: Path) -> None:
    """Machine code of all modules of a group in `folder`, C sources beside it while it works."""
    from mypyc.build import mypycify
    from setuptools import Distribution
    from setuptools.command.build_ext import build_ext
    from setuptools.errors import CCompilerError, ExecError, PlatformError

    before = Path.cwd()
    os.chdir(PACKAGE_ROOT)
    try:
        with (
            tempfile.TemporaryDirectory(dir=folder) as scratch,
            contextlib.redirect_stdout(io.StringIO()) as told,
        ):
            types = Path(scratch) / "types.ini"
            types.write_text(TYPES)
            paths = [str(path.relative_to(PACKAGE_ROOT)) for path in engine.sources(group)]
            name = engine.library(group)
            extensions = mypycify(
                ["--config-file", str(types), "--cache-dir", f"{scratch}/types", *paths],
                target_dir=scratch,
                opt_level=OPTIMISATION,
                debug_level="0",
                group_name=name.removesuffix("__mypyc"),
            )
            wanted = [extension for extension in extensions if extension.name == name]
            command = build_ext(Distribution({"name": name, "ext_modules": wanted}))
            command.build_lib, command.build_temp = str(folder), scratch
            command.ensure_finalized()
            command.run()
    except SystemExit as error:
        sys.stderr.write(told.getvalue())
        raise NotPossibleError("mypyc does not translate these sources") from error
    except OSError as error:
        raise NotPossibleError(f"{folder} cannot be filled ({error.strerror})") from error
    except (CCompilerError, ExecError, PlatformError) as error:
        raise NotPossibleError(
            f"no C compiler that works with this Python (Debian: apt install gcc python3-dev; {error})"
        ) from error
    finally:
        os.chdir(before)


def _drop_older(parent: Path, group: str) -> None:
    """All but the last builds of a group in this environment, those of groups that are no more, and what
    interrupted ones have left. A process that has a dropped one open keeps it."""
    ages = {folder: time.time() - folder.stat().st_mtime for folder in parent.iterdir()}
    built = sorted((path for path in ages if path.name.startswith(f"{group}-")), key=ages.__getitem__)
    interrupted = [path for path in ages if path.name.startswith(UNFINISHED) and ages[path] > LONGEST_BUILD_S]
    known = tuple(f"{name}-" for name in (*GROUPS, UNFINISHED.removesuffix("-")))
    strangers = [path for path in ages if not path.name.startswith(known)]
    for path in [*built[BUILDS_KEPT:], *strangers, *interrupted]:
        shutil.rmtree(path, ignore_errors=True)


def main(groups: Sequence[str]) -> None:
    """Build what is missing, and say what came of it in one line."""
    missing = [group for group in groups if not engine.folder(group).exists()]
    if not missing:
        return
    print("navtwin: translating the emulator's engine to machine code …", flush=True)
    started = time.monotonic()
    try:
        for group in missing:
            build(group)
    except NotPossibleError as error:
        print(f"navtwin: the engine stays interpreted: {error}", file=sys.stderr)
    else:
        print(f"navtwin: engine built in {time.monotonic() - started:.0f} s")


if __name__ == "__main__":
    main(sys.argv[1:] or list(GROUPS))
