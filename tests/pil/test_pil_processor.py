"""Twin and emulated processor side by side. Skipped where the compiler or QEMU is missing."""

import json

import pytest
from pil_tools import compared, needs_processor, small_image

from host.cli.pil_run import Asked, execute
from host.pil.qemu import instructions
from host.pil.target_code import undefined_symbols
from host.record.result import RunRequest

pytestmark = needs_processor
SINE = "firmware.numerics.trigonometry.sine_cosine"


class LosingPort:
    """A port that loses a byte of every fifth write and of about every tenth read."""

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
        self.reads += len(found) > 2
        if len(found) > 2 and self.reads % 10 == 0:
            self.lost += 1
            found = found[1:]
        return found


def test_the_processor_computes_the_same_bits_over_a_line_that_loses_bytes():
    ports = []
    lockstep, link = compared(batch=2, spoil=lambda port: ports.append(LosingPort(port)) or ports[0])
    assert (lockstep.compared, lockstep.differences) == (60, [])
    assert ports[0].lost > 2
    assert link.trouble.damaged + link.trouble.refused + link.trouble.silent > 1


def test_a_processor_that_rounds_otherwise_is_caught():
    lockstep, _ = compared(planted="rounding")
    first = lockstep.differences[0]
    assert first.kernel.startswith("firmware.numerics.")
    assert first.twin != first.target
    assert 1 <= first.ulp < 1000


def test_an_image_leaves_nothing_undefined():
    image = small_image()
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


@pytest.mark.soak
def test_instructions_are_counted_exactly():
    """The same work is the same number of instructions whenever it is done."""
    first, again = (compared(steps=30, counting=True)[0].counts[SINE] for _ in range(2))
    assert 30 < instructions(first.least) < 500
    assert abs(instructions(again.total - first.total)) <= 2
