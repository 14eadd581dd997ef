"""All kernels of the product, or of a file of samples, made by a decorator of one's choice.

A sample file looks like a file of firmware; it is run with the decorator in the place of the dialect's own.
"""

import importlib
import pkgutil
import re
import runpy
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import firmware
from firmware.numerics import dialect
from firmware.numerics.signature import Signature, parse_signature
from firmware.numerics.variants import KernelVariant

REPOSITORY = Path(__file__).resolve().parents[2]
DECORATED = re.compile(r"^@kernel\b", re.MULTILINE)

# Float64 on purpose: stands for `trigonometry` on the PC when float32 is to be judged; never on a target.
NOT_ON_BOARD = frozenset({"firmware.numerics.reference_trigonometry"})

Decorate = Callable[[Callable[..., Any], Signature | None], Any]


@dataclass(frozen=True, slots=True)
class Built:
    """One kernel: its full name, the plain function, its signature if declared, what the decorator made."""

    name: str
    function: Callable[..., Any]
    signature: Signature | None
    made: Any


def kernel_modules(package: str = "firmware") -> list[str]:
    """Names of all modules at or below `package` whose source decorates a kernel."""
    names = []
    for module in pkgutil.walk_packages(firmware.__path__, "firmware."):
        place = module.name.split(".") + ["__init__"] * module.ispkg
        source = REPOSITORY.joinpath(*place).with_suffix(".py")  # its code may be elsewhere, in the engine
        assert source.is_file(), f"{module.name} has no source: an __init__.py is missing"
        if module.name in NOT_ON_BOARD or not f"{module.name}.".startswith(f"{package}."):
            continue
        if DECORATED.search(source.read_text(encoding="utf-8")):
            names.append(module.name)
    return names


def registered_product(package: str = "firmware") -> dict[str, Built]:
    """Every kernel below `package` as the product itself runs it."""
    for module in kernel_modules(package):
        importlib.import_module(module)
    return {
        kernel.name: Built(kernel.name, kernel.function, kernel.signature, kernel.callable)
        for kernel in dialect.registered_kernels()
        if kernel.name.startswith(package + ".") and kernel.function.__module__ not in NOT_ON_BOARD
    }


def build_product(variant: str, decorate: Decorate, package: str = "firmware") -> dict[str, Built]:
    """Every kernel below `package`, and what these call, made by `decorate` in modules of their own."""
    built: dict[str, Built] = {}

    def make(function: Callable[..., Any], signature: Signature | None) -> Any:
        made = decorate(function, signature)
        name = f"firmware{function.__module__[len(modules.root) :]}.{function.__qualname__}"
        built[name] = Built(name, function, signature, made)
        return made

    modules = KernelVariant(variant, make)
    for module in kernel_modules(package):
        modules.load(module)
    return built


def build_samples(path: Path, decorate: Decorate) -> dict[str, Built]:
    """Every kernel of the sample file made by `decorate`."""
    built: dict[str, Built] = {}

    def make(function: Callable[..., Any], signature: Signature | None) -> Any:
        made = decorate(function, signature)
        built[function.__qualname__] = Built(function.__qualname__, function, signature, made)
        return made

    def kernel(declaration: Any) -> Any:
        if not isinstance(declaration, str):
            return make(declaration, None)
        return lambda function: make(function, parse_signature(declaration))

    ordinary = dialect.kernel
    dialect.kernel = kernel
    try:
        runpy.run_path(str(path), run_name=f"samples_{path.stem}")
    finally:
        dialect.kernel = ordinary
    return built
