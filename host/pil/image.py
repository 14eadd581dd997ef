"""Images for the STM32F405: kernels and monitor linked, checked, kept until a source changes."""

from __future__ import annotations

import hashlib
import json
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import firmware.target
from firmware.link.stand_alone import StandAlone
from firmware.numerics.cache_folder import kernel_cache_folder, kernel_sources_hash
from host.pil.kernel_table import TargetKernel, table_source
from host.pil.planted import C_DEFINITIONS
from host.pil.stand_alone import loop_source
from host.pil.target_code import ROLLED, UNROLLED
from host.pil.toolchain import COMPILER, check_library, run_tool, version_of
from host.record.errors import UserError

SOURCES = Path(firmware.target.__path__[0])
HERE = Path(__file__).parent
BAUD = 460_800
LARGEST_IMAGE = 64 * 1024
MACHINE = ("-mcpu=cortex-m4", "-mthumb", "-mfpu=fpv4-sp-d16", "-mfloat-abi=hard")
COMPILE = ("-std=c11", "-O2", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off", "-ffreestanding",
           "-ffunction-sections", "-fdata-sections")  # fmt: skip
LINK = ("-nostartfiles", "--specs=nano.specs", "--specs=nosys.specs", "-Wl,--gc-sections",
        "-Wl,--no-warn-rwx-segments")  # fmt: skip
SUFFIXES = ("elf", "hex", "bin")
COMPILE_SECONDS = 600


@dataclass(frozen=True, slots=True)
class Making:
    """How kernels are compiled."""

    planted: str | None = None
    loops: str = UNROLLED


@dataclass(frozen=True, slots=True)
class Image:
    """A linked image: file names without suffix are `path`; bytes by section and by kernel."""

    path: Path
    identity: str
    kernels: tuple[TargetKernel, ...]
    sections: dict[str, int]
    symbols: dict[str, int]
    versions: dict[str, str]

    def file(self, suffix: str) -> Path:
        """Its ELF, HEX or BIN file."""
        return self.path.with_suffix(f".{suffix}")

    @property
    def size(self) -> int:
        """Bytes of flash."""
        return self.sections["text"] + self.sections["data"]


def build_image(
    kernels: Sequence[TargetKernel],
    planted: str | None = None,
    limit: int | None = None,
    loop: StandAlone | None = None,
) -> Image:
    """The image of these kernels, and of a navigation loop of them; from the cache when it was built before.

    `limit`: bytes of flash that it may take; one that takes more is made again with its loops rolled. Raises
    UserError for missing tools, and RuntimeError for kernels that leave symbols undefined, pass floats in
    integer registers or hold fused operations unasked.
    """
    image = _made(kernels, Making(planted), loop)
    if limit is not None and image.size > limit:
        image = _made(kernels, Making(planted, ROLLED), loop)
    if limit is not None and image.size > limit:
        raise UserError(f"the image takes {image.size} bytes of flash, more than {limit}")
    return image


def _made(kernels: Sequence[TargetKernel], making: Making, loop: StandAlone | None) -> Image:
    compiler = version_of(COMPILER)
    check_library()
    loop_table = loop_source(loop, kernels)
    identity = _identity(kernels, loop_table, compiler, making)
    folder = kernel_cache_folder("target images")
    if folder is None:
        folder = Path(tempfile.mkdtemp(prefix="navtwin-image-"))
    path = folder / f"image_{identity}"
    told = path.with_suffix(".json")
    if not told.is_file():
        with tempfile.TemporaryDirectory(dir=folder) as place:
            Path(place, "loop_table.c").write_text(loop_table, encoding="utf-8")
            _build(Path(place), kernels, identity, compiler, making)
            for suffix in (*SUFFIXES, "json"):  # the last one says that the others are there
                Path(place, f"image.{suffix}").replace(path.with_suffix(f".{suffix}"))
    facts = json.loads(told.read_text(encoding="utf-8"))
    return Image(path, identity, tuple(kernels), **facts)


def _identity(kernels: Sequence[TargetKernel], loop_table: str, compiler: str, making: Making) -> str:
    """16 hex digits over all that the image is made of."""
    monitor = [*SOURCES.glob("*.[ch]"), *SOURCES.glob("*.ld"), HERE / "kernel_table.py", HERE / "image.py"]
    return _hash(monitor, (_identity_of_code(kernels, making), loop_table, making, compiler, BAUD))


def _identity_of_code(kernels: Sequence[TargetKernel], making: Making) -> str:
    makers = [HERE / name for name in ("target_code.py", "planted.py", "compile_kernels.py")]
    names = [(kernel.name, kernel.signature.text) for kernel in kernels]
    tools = (sys.version, version("numba"), version("llvmlite"), version("numpy"))
    return kernel_sources_hash(_hash(makers, (names, tools, making)))


def _hash(files: Sequence[Path], facts: object) -> str:
    digest = hashlib.sha256(repr(facts).encode())
    for path in sorted(files):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def _build(
    place: Path, kernels: Sequence[TargetKernel], identity: str, compiler: str, making: Making
) -> None:
    code, found = _compiled_once(place.parent, kernels, making)
    _check(found, making.planted)
    table = place / "kernel_table.c"
    table.write_text(table_source(kernels, identity), encoding="utf-8")
    definitions = (f"-DSERIAL_BAUD={BAUD}u", *C_DEFINITIONS.get(making.planted or "", ()))
    elf = place / "image.elf"
    sources = [*sorted(SOURCES.glob("*.c")), table, place / "loop_table.c"]
    run_tool(COMPILER.program, *MACHINE, *COMPILE, *definitions, f"-I{SOURCES}", *sources, code, *LINK,
             f"-T{SOURCES / 'stm32f405.ld'}", "-o", elf)  # fmt: skip
    _check_hard_float(elf)
    run_tool("arm-none-eabi-objcopy", "-O", "ihex", elf, place / "image.hex")
    run_tool("arm-none-eabi-objcopy", "-O", "binary", elf, place / "image.bin")
    versions = {"gcc": compiler, "llvm": found["llvm"], "numba": found["numba"]}
    facts = {"sections": _sections(elf), "symbols": _symbols(elf), "versions": versions}
    (place / "image.json").write_text(json.dumps(facts), encoding="utf-8")


def _compiled_once(
    folder: Path, kernels: Sequence[TargetKernel], making: Making
) -> tuple[Path, dict[str, Any]]:
    """Kernels as one object file in `folder`, and what the compiler found out about it."""
    kept = folder / f"kernels_{_identity_of_code(kernels, making)}"
    code, told = kept.with_suffix(".o"), kept.with_suffix(".found")
    if not told.is_file():
        unfinished = kept.with_suffix(f".{os.getpid()}")
        found = _compiled(unfinished, kernels, making)
        unfinished.replace(code)
        unfinished.write_text(json.dumps(found), encoding="utf-8")
        unfinished.replace(told)
    return code, json.loads(told.read_text(encoding="utf-8"))


def _compiled(code: Path, kernels: Sequence[TargetKernel], making: Making) -> dict[str, Any]:
    root = SOURCES.parents[1]
    paths = [str(root), *filter(None, [os.environ.get("PYTHONPATH")])]
    quiet = {"NUMBA_OPT": "0", "NUMBA_DISABLE_JIT": "0", "PYTHONPATH": os.pathsep.join(paths)}
    asked = [str(code), making.loops, *([making.planted] if making.planted else [])]
    command = [sys.executable, "-m", "host.pil.compile_kernels", *asked]
    names = "\n".join(f"{kernel.name} {kernel.signature.text}" for kernel in kernels)
    done = subprocess.run(
        command,
        input=names,
        env=os.environ | quiet,
        capture_output=True,
        text=True,
        check=False,
        timeout=COMPILE_SECONDS,
    )
    if done.returncode != 0:
        raise RuntimeError(f"kernels do not compile for the target:\n{done.stderr}")
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return found


def _check(found: dict[str, Any], planted: str | None) -> None:
    if found["undefined"]:
        raise RuntimeError(f"kernels call what the target does not have: {', '.join(found['undefined'])}")
    if not found["hard_float"]:
        raise RuntimeError("kernels are compiled for the soft-float calling convention")
    if planted == "fma" and not found["fused"]:
        raise UserError("--plant fma: these kernels have no product in a sum; for example --plant constant")
    if found["fused"] and planted != "fma":
        raise RuntimeError(f"kernels hold {found['fused']} fused multiply-adds")


def _check_hard_float(elf: Path) -> None:
    """The linker marks an image whose parts all pass floats in float registers."""
    header = run_tool("arm-none-eabi-readelf", "-h", elf)
    if "hard-float ABI" not in header:
        raise RuntimeError(f"{elf.name} does not have the hard-float ABI")


def _sections(elf: Path) -> dict[str, int]:
    numbers = run_tool("arm-none-eabi-size", elf).splitlines()[1].split()[:3]
    return dict(zip(("text", "data", "bss"), map(int, numbers), strict=True))


def _symbols(elf: Path) -> dict[str, int]:
    """Bytes of code of each function."""
    found = {}
    for line in run_tool("arm-none-eabi-nm", "-S", "--defined-only", elf).splitlines():
        if match := re.fullmatch(r"\S+ (\S+) [tT] (\S+)", line):
            found[match[2]] = int(match[1], 16)
    return found
