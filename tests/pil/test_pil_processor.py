"""Twin and emulated processor side by side. Skipped where the compiler or QEMU is missing."""

import json
import shutil

import numpy as np
import pytest

from firmware.numerics import trigonometry
from firmware.numerics.dialect import registered_kernels
from host.cli.pil_run import Asked, execute
from host.pil.board_kernels import target_kernel
from host.pil.image import build_image
from host.pil.lockstep import Lockstep
from host.pil.monitor_link import MonitorLink, open_port
from host.pil.qemu import emulated_board, instructions
from host.pil.target_code import undefined_symbols
from host.record.result import RunRequest

MISSING = [tool for tool in ("arm-none-eabi-gcc", "qemu-system-arm") if shutil.which(tool) is None]
pytestmark = pytest.mark.skipif(
    bool(MISSING),
    reason=f"{MISSING} missing: apt install gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm",
)

SMALL = (trigonometry.arc_tangent2, trigonometry.sine_cosine)


def small_kernels():
    names = [f"{one.py_func.__module__}.{one.py_func.__qualname__}" for one in SMALL]
    by_name = {kernel.name: kernel for kernel in registered_kernels()}
    return [target_kernel(number, by_name[name]) for number, name in enumerate(names)]


def compared(steps=60, batch=300, planted=None, spoil=None, counting=False):
    """A lockstep of the small kernels with ordinary numbers, and its link."""
    image = build_image(small_kernels(), planted)
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


def test_the_processor_computes_the_same_bits():
    lockstep, link = compared()
    assert (lockstep.compared, lockstep.differences) == (60, [])
    assert link.trouble.damaged == link.trouble.refused == 0


@pytest.mark.parametrize("planted", ["fma", "constant", "rounding"])
def test_a_planted_difference_is_caught(planted):
    lockstep, _ = compared(planted=planted)
    first = lockstep.differences[0]
    assert first.kernel.startswith("firmware.numerics.")
    assert first.twin != first.target
    assert 1 <= first.ulp < 1000


class LosingPort:
    """A port that loses a byte of every fifth write and of every fortieth read."""

    def __init__(self, port):
        self._port, self.writes, self.reads, self.lost = port, 0, 0, 0

    def __getattr__(self, name):
        return getattr(self._port, name)

    def write(self, line):
        self.writes += 1
        if self.writes % 5 == 0:
            self.lost += 1
            line = line[: len(line) // 2] + line[len(line) // 2 + 1 :]
        return self._port.write(line)

    def read(self, size):
        found = self._port.read(size)
        self.reads += bool(found)
        if found and self.reads % 40 == 0:
            self.lost += 1
            found = found[:-1]
        return found


def test_lost_bytes_are_detected_and_the_work_goes_on():
    ports = []
    lockstep, link = compared(batch=2, spoil=lambda port: ports.append(LosingPort(port)) or ports[0])
    assert (lockstep.compared, lockstep.differences) == (60, [])
    assert ports[0].lost > 2
    assert link.trouble.damaged + link.trouble.refused + link.trouble.silent > 1


def test_instructions_are_counted_exactly():
    """The same work is the same number of instructions whenever it is done."""
    lockstep, _ = compared(steps=30, counting=True)
    counts = lockstep.counts["firmware.numerics.trigonometry.sine_cosine"]
    assert 30 < instructions(counts.least) < 500
    again, _ = compared(steps=30, counting=True)
    assert (
        abs(instructions(again.counts["firmware.numerics.trigonometry.sine_cosine"].total - counts.total))
        <= 2
    )


def test_an_image_leaves_nothing_undefined():
    image = build_image(small_kernels())
    assert undefined_symbols(image.file("elf").read_bytes()) == []
    assert image.file("bin").stat().st_size == image.size <= 64 * 1024
    assert image.file("hex").read_text().splitlines()[-1] == ":00000001FF"


def test_two_hundred_steps_of_the_attitude_computer(tmp_path, capfd):
    figures = tmp_path / "pil.json"
    request = RunRequest("uav_ahrs", "flight", "document")
    code = execute(Asked(request, 200, None, False, False, None), str(figures), quiet=True)
    found = json.loads(figures.read_text())
    assert (code, found["steps"], found["differences"], found["first_difference"]) == (0, 200, 0, None)
    assert found["image_bytes"] <= 64 * 1024
    assert "equal: 200 steps on QEMU netduinoplus2" in capfd.readouterr().out
