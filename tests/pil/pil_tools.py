"""A small image for tests of the processor in the loop, and the skip where its tools are missing."""

from __future__ import annotations

import functools
import shutil

import numpy as np
import pytest

from firmware.numerics import trigonometry
from firmware.numerics.dialect import registered_kernels
from host.pil.board_kernels import target_kernel
from host.pil.image import build_image
from host.pil.lockstep import Lockstep
from host.pil.monitor_link import MonitorLink, open_port
from host.pil.qemu import emulated_board

MISSING = [tool for tool in ("arm-none-eabi-gcc", "qemu-system-arm") if shutil.which(tool) is None]
needs_processor = pytest.mark.skipif(
    bool(MISSING),
    reason=f"{MISSING} missing: apt install gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm",
)

SMALL = (trigonometry.arc_tangent2, trigonometry.sine_cosine)


def small_kernels():
    names = [f"{one.py_func.__module__}.{one.py_func.__qualname__}" for one in SMALL]
    by_name = {kernel.name: kernel for kernel in registered_kernels()}
    return [target_kernel(number, by_name[name]) for number, name in enumerate(names)]


@functools.cache
def small_image(planted=None):
    return build_image(small_kernels(), planted)


def compared(steps=60, batch=300, planted=None, spoil=None, counting=False):
    """A lockstep of the small kernels with ordinary numbers, and its link."""
    image = small_image(planted)
    rng = np.random.Generator(np.random.PCG64(5))
    with emulated_board(image.file("elf"), counting) as name, open_port(name) as port:
        link = MonitorLink(port if spoil is None else spoil(port), name)
        lockstep = Lockstep(link, image, link.greet(image.identity).memory, steps)
        while not lockstep.is_over:
            for kernel, made in zip(image.kernels, SMALL, strict=True):
                values = rng.normal(0.0, 2.0, 3).astype(np.float32)
                arguments = [
                    np.zeros(8, np.float32) if one.is_array else values[place % 3]
                    for place, one in enumerate(kernel.signature.arguments)
                ]
                lockstep.call(kernel, made, *arguments)
            if lockstep.steps % batch == 0:
                lockstep.flush()
        lockstep.flush()
    return lockstep, link
