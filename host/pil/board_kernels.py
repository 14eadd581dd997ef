"""Which kernels an image of a board holds: the entries of navigation that its firmware asks for."""

from __future__ import annotations

from boards.assembly import assemble
from firmware.numerics.dialect import Kernel, entries_named, registered_kernels
from host.pil.kernel_table import TargetKernel
from host.record.errors import UserError
from host.run.setup import Setup
from host.run.surroundings import Surroundings
from host.run.warm_up import BOOT_NS
from host.sim.world import World

NAVIGATION = ("firmware.nav.", "firmware.apps.")
"""Where what navigates lies."""
ALL = ("firmware.",)
"""With parsers and frames."""


def kernels_of(setup: Setup, world: World, packages: tuple[str, ...] = NAVIGATION) -> list[TargetKernel]:
    """Of a board with one profile, which boots for this in a world of its own. Raises UserError."""
    with entries_named() as asked:
        board = assemble(setup.board, setup.profile, Surroundings(world, None))
        board.machine.run_until(BOOT_NS)
        board.machine.power_off()
    functions = dict.fromkeys(kernel.py_func for kernel in asked)
    names = {f"{function.__module__}.{function.__qualname__}" for function in functions}
    if any(name.startswith("firmware_float64.") for name in names):
        known = [name for name, profile in setup.board.profiles.items() if "float64" not in repr(profile)]
        raise UserError(
            f"--profile {setup.profile_name}: computes in float64, which the Cortex-M4F has not;"
            f" for example --profile {next(iter(known), setup.board.default_profile)}"
        )
    found = [
        kernel
        for kernel in registered_kernels()
        if kernel.name in names and kernel.name.startswith(packages) and kernel.signature is not None
    ]
    if not found:
        raise UserError(f"board {setup.board.name}: its program asks for no kernels of navigation")
    return [target_kernel(number, kernel) for number, kernel in enumerate(found)]


def target_kernel(number: int, kernel: Kernel) -> TargetKernel:
    """A registered kernel, which has a signature, under its number in an image."""
    assert kernel.signature is not None
    code = kernel.function.__code__
    return TargetKernel(number, kernel.name, kernel.signature, code.co_varnames[: code.co_argcount])
