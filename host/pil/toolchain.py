"""The tools outside Python: found, their versions checked, or one message that says what to install."""

from __future__ import annotations

import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

from host.record.errors import UserError


@dataclass(frozen=True, slots=True)
class Tool:
    """A program, the Debian packages that bring it, and the versions (of the first number) that will do."""

    program: str
    packages: str
    versions: range


COMPILER = Tool("arm-none-eabi-gcc", "gcc-arm-none-eabi libnewlib-arm-none-eabi", range(10, 16))
EMULATOR = Tool("qemu-system-arm", "qemu-system-arm", range(6, 12))


def check_tools(*tools: Tool) -> None:
    """Raises UserError when one is missing, too old or too new; all that are missing in one message."""
    _check_installed(*tools)
    for tool in tools:
        version_of(tool)


def _check_installed(*tools: Tool) -> None:
    missing = [tool for tool in tools if shutil.which(tool.program) is None]
    if missing:
        programs = " and ".join(tool.program for tool in missing)
        packages = " ".join(tool.packages for tool in missing)
        verb = "is" if len(missing) == 1 else "are"
        raise UserError(f"{programs} {verb} not installed; on Debian and Ubuntu: apt install {packages}")


def version_of(tool: Tool) -> str:
    """The version, e.g. "12.2.1". Raises UserError when the tool is missing, too old or too new."""
    _check_installed(tool)
    text = _output([tool.program, "--version"])
    found = re.search(r"\b(\d+)\.\d+(?:\.\d+)*\b", re.sub(r"\([^)]*\)", "", text.partition("\n")[0]))
    if found is None or int(found[1]) not in tool.versions:
        wanted = f"{tool.versions.start} to {tool.versions.stop - 1}"
        told = "an unknown version" if found is None else found[0]
        raise UserError(f"{tool.program} is {told}; versions {wanted} are known to work ({tool.packages})")
    return found[0]


def check_library() -> None:
    """Raises UserError when the C library of the target is missing: memcpy and memset come from it."""
    place = _output([COMPILER.program, "-mcpu=cortex-m4", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16",
                     "-print-file-name=libc_nano.a"]).strip()  # fmt: skip
    if not Path(place).is_file():
        raise UserError(
            f"{COMPILER.program} has no newlib; on Debian and Ubuntu: apt install libnewlib-arm-none-eabi"
        )


def run_tool(*command: str | Path) -> str:
    """Standard output of a tool of the compiler. RuntimeError with its messages when it fails, which is a
    defect of ours; UserError when it is missing."""
    try:
        done = subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False)
    except FileNotFoundError:
        raise UserError(
            f"{command[0]} is not installed; on Debian and Ubuntu: apt install binutils-arm-none-eabi"
        ) from None
    if done.returncode != 0:
        raise RuntimeError(f"{command[0]} failed:\n{done.stderr.strip()}")
    return done.stdout


def _output(command: list[str]) -> str:
    try:
        return subprocess.run(command, capture_output=True, text=True, check=False, timeout=30).stdout
    except (OSError, subprocess.TimeoutExpired) as error:
        raise UserError(f"{command[0]} cannot be run: {error}") from None
