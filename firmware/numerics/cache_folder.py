"""Where compiled kernels are kept between runs: one folder per state of the kernels' sources.

Numba's own cache looks at the file of the kernel it compiles only: a kernel that calls a changed one in
another file would keep the old code. So the folder's name is a hash of every source a kernel can see:
all firmware files that use the decorator, what they import from firmware, the builders of kernels here,
and the versions of Python and numba. The same folder may be used by any number of processes at once (numba
writes aside and renames, and each kernel has one signature, hence one content).
"""

import contextlib
import functools
import hashlib
import os
import re
import shutil
import stat
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

FOLDERS_KEPT = 30  # about 1 MB each
_PACKAGE_ROOT = Path(__file__).resolve().parents[2]
_DECORATOR_USED = re.compile(r"^@kernel\b", re.MULTILINE)
_IMPORT = re.compile(r"^\s*(?:from|import)\s+([\w.]+)", re.MULTILINE)


def kernel_cache_folder(versions: str) -> Path | None:
    """The folder for the present sources, created; None when no place is writable (then nothing is kept)."""
    name = kernel_sources_hash(versions)
    for root in _candidate_roots():
        folder = root / "kernels" / name
        try:
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            tempfile.TemporaryFile(dir=folder).close()
        except OSError:
            continue
        if _is_private(folder):
            os.utime(folder)
            _drop_oldest(folder.parent)
            return folder
    return None


def kernel_sources_hash(versions: str) -> str:
    """16 hex digits over the text of all kernel sources and `versions`."""
    return hashlib.sha256(versions.encode() + _digest_of_sources()).hexdigest()[:16]


@functools.cache
def _digest_of_sources() -> bytes:
    digest = hashlib.sha256()
    for path in sorted(kernel_sources()):
        digest.update(str(path.relative_to(_PACKAGE_ROOT)).encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.digest()


def hash_of_folder_outside(source: Path) -> str:
    """For a kernel outside of firmware (a test's): hash of the files beside it; empty inside firmware."""
    if source.is_relative_to(_PACKAGE_ROOT / "firmware"):
        return ""
    digest = hashlib.sha256()
    for path in sorted(source.parent.glob("*.py")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


def kernel_sources() -> set[Path]:
    """Files of firmware that hold or build kernels, and all firmware files these import, however far."""
    texts = {path: path.read_text(encoding="utf-8") for path in (_PACKAGE_ROOT / "firmware").rglob("*.py")}
    modules = {_module_name(path): path for path in texts}
    packages: dict[str, list[Path]] = {}
    for name, path in modules.items():
        packages.setdefault(name.rpartition(".")[0], []).append(path)
    builders = Path(__file__).parent
    found = {path for path, text in texts.items() if path.parent == builders or _DECORATOR_USED.search(text)}
    waiting = list(found)
    looked_at: set[str] = set()
    while waiting:
        path = waiting.pop()
        new = set()
        for module in _imported_modules(texts[path], path) - looked_at:
            looked_at.add(module)
            new |= {modules[module]} if module in modules else set()
            new.update(packages.get(module, ()))
        waiting.extend(new - found)
        found |= new
    return found


def _imported_modules(text: str, importer: Path) -> set[str]:
    """Modules of firmware that `text` may import; a package stands for all files in its folder, and so does
    what is named from where the importer stands."""
    names = set(_IMPORT.findall(text))
    imported = {name for name in names if name.startswith("firmware.")}
    if any(name.startswith(".") for name in names):
        imported.add(_module_name(importer).rpartition(".")[0])
    return imported


def _module_name(path: Path) -> str:
    return ".".join(path.relative_to(_PACKAGE_ROOT).with_suffix("").parts)


def _candidate_roots() -> Iterator[Path]:
    if given := os.environ.get("XDG_CACHE_HOME"):
        yield Path(given) / "navtwin"
    home = os.environ.get("LOCALAPPDATA") if sys.platform == "win32" else None
    with contextlib.suppress(RuntimeError):  # no home directory can be determined
        yield (Path(home) if home else Path.home() / ".cache") / "navtwin"
    user = os.getuid() if hasattr(os, "getuid") else os.environ.get("USERNAME", "user")
    yield Path(tempfile.gettempdir()) / f"navtwin-{user}"


def _is_private(folder: Path) -> bool:
    """Cached code is executed: a folder that others own or may write to is refused."""
    if not hasattr(os, "getuid"):
        return True
    return all(
        status.st_uid == os.getuid() and not status.st_mode & stat.S_IWOTH
        for status in (folder.stat(), folder.parent.stat(), folder.parent.parent.stat())
    )


def _drop_oldest(parent: Path) -> None:
    """Keep the folders used last; a process that loses its folder compiles again."""
    try:
        folders = sorted(parent.iterdir(), key=lambda folder: folder.stat().st_mtime, reverse=True)
    except OSError:  # another process is tidying up
        return
    for folder in folders[FOLDERS_KEPT:]:
        shutil.rmtree(folder, ignore_errors=True)
