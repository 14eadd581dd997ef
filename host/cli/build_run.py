"""What `navtwin build` does."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from rich.console import Console
from rich.table import Table

from boards.description import load_board
from host.cli.exit_codes import EXIT_MET
from host.cli.output_files import check_files, for_people, write_json
from host.pil.image import SUFFIXES, Image
from host.pil.session import image_of
from host.pil.target_code import entry_symbol
from host.record.errors import UserError
from host.record.result import RunRequest

TARGETS = ("stm32f405",)


def execute(board: str, target: str, profile: str | None, out: Path, json: str | None, quiet: bool) -> int:
    """Build, copy, print. Raises UserError."""
    if target not in TARGETS:
        raise UserError(f"--target {target}: not known; for example --target {TARGETS[0]}")
    check_files(("--json", json))
    _check_folder(out)
    image = image_of(RunRequest(board, profile=profile))
    description = load_board(board)
    stem = f"{description.name}-{profile or description.default_profile}-{target}"
    try:
        out.mkdir(parents=True, exist_ok=True)
        files = [shutil.copyfile(image.file(suffix), out / f"{stem}.{suffix}") for suffix in SUFFIXES]
    except OSError as error:
        raise UserError(f"--out {out}: {error.strerror}; name another folder, e.g. --out build") from None
    write_json(_figures(image, files), json)
    console = for_people(json)
    if not quiet:
        _print_sizes(console, image)
    console.print(
        f"{files[0]}, .hex, .bin: {image.size} bytes of flash, image {image.identity}", soft_wrap=True
    )
    return EXIT_MET


def _check_folder(out: Path) -> None:
    if out.exists() and not out.is_dir():
        raise UserError(f"--out {out}: is a file; name a folder, e.g. --out build")


def _figures(image: Image, files: list[Path]) -> dict[str, object]:
    return {
        "format": "navtwin-image-1",
        "identity": image.identity,
        "files": [str(file) for file in files],
        "flash_bytes": image.size,
        "sections": image.sections,
        "functions": image.symbols,
        "kernels": [kernel.name for kernel in image.kernels],
        "undefined_symbols": [],
        "hard_float": True,
        "versions": image.versions,
    }


def _print_sizes(console: Console, image: Image) -> None:
    table = Table("bytes of code", "function")
    entries = {entry_symbol(kernel.number): kernel.name for kernel in image.kernels}
    for symbol, size in sorted(image.symbols.items(), key=lambda item: -item[1])[:20]:
        table.add_row(str(size), entries.get(symbol, _readable(symbol)))
    console.print(table)
    sections = ", ".join(f"{name} {size}" for name, size in image.sections.items())
    tools = ", ".join(f"{name} {version}" for name, version in image.versions.items())
    console.print(f"{sections}; hard-float ABI, no undefined symbols; {tools}", soft_wrap=True)


def _readable(symbol: str) -> str:
    """The kernel in a name that numba mangled, e.g. _ZN15firmware_target3nav6strapdown4stepB…"""
    parts, rest = [], symbol.removeprefix("_ZN")
    while rest != symbol and (found := re.match(r"(\d+)", rest)):
        length = int(found[1])
        parts.append(rest[found.end() : found.end() + length])
        rest = rest[found.end() + length :]
    return ".".join(parts).replace("firmware_target", "firmware") if parts else symbol
