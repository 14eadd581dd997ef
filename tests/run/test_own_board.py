"""A board and a program outside the repository, and programs that never end."""

from __future__ import annotations

from pathlib import Path

import pytest

from boards import machine
from hal.emulated import cpu
from hal.endings import SpinError
from host.record.errors import UserError
from host.record.result import RunRequest
from host.run.runner import run

BOARD = """
name = "tiny"
title = "one sensor, one line out"
default_profile = "plain"
default_scenario = "still"

[processors.brain]
part = "STM32F405"
clock_hz = 168_000_000
program = "tiny_program:{factory}"
tasks = {{ worker = {{ priority = 2 }} }}

[buses.spi1]
kind = "spi"
processor = "brain"
clock_hz = 5_000_000

[chips.U1]
part = "BMI160"
model = "boards.chips.bmi160:Bmi160"
bus = "spi1"
name = "imu"
world = "imu"

[uarts.host]
processor = "brain"
baud = 115_200

[timers.tick]
processor = "brain"

[profiles.plain]
"""

PROGRAM = """
class Tiny:
    def __init__(self, io):
        self.io = io
        self.ticks = 0

    def main(self):
        line = self.io.interrupts.attach("worker", self.work)
        self.io.timers["tick"].start(10, line)
        while True:
            self.io.cpu.wait_for_interrupt()

    def work(self):
        self.ticks += 1
        request = bytearray((0x80, 0x00))
        self.io.spi["imu"].transaction(request)
        self.io.uart["host"].write(bytes(request))

    def spoil(self):
        pass

    def memory(self):
        return bytes([self.ticks % 256])


class OnI2c(Tiny):
    def work(self):
        self.ticks += 1
        self.io.uart["host"].write(self.io.i2c["spi1"].transaction(0x68, bytes(1), 1))


class Endless(Tiny):
    def work(self):
        while True:
            pass


class Polling(Tiny):
    def work(self):
        while self.io.clock.now_ns() >= 0:
            pass


class Unknown(Tiny):
    def main(self):
        self.io.interrupts.attach("nobody", self.work)


def works(io, profile, installation):
    return Tiny(io)


def on_i2c(io, profile, installation):
    return OnI2c(io)


def endless(io, profile, installation):
    return Endless(io)


def polling(io, profile, installation):
    return Polling(io)


def unknown(io, profile, installation):
    return Unknown(io)
"""

STILL = """
duration_s = 5.0
[place]
latitude_deg = 30.0
longitude_deg = 114.0
"""


@pytest.fixture
def board(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):  # type: ignore[no-untyped-def]
    monkeypatch.syspath_prepend(str(tmp_path))
    (tmp_path / "tiny_program.py").write_text(PROGRAM)
    (tmp_path / "tiny" / "scenarios").mkdir(parents=True)
    (tmp_path / "tiny" / "scenarios" / "still.toml").write_text(STILL)

    def with_program(factory: str) -> RunRequest:
        (tmp_path / "tiny" / "board.toml").write_text(BOARD.format(factory=factory))
        return RunRequest(str(tmp_path / "tiny"))

    return with_program


def test_board_outside_the_repository_runs(board) -> None:  # type: ignore[no-untyped-def]
    result = run(board("works"))
    assert result.board == "tiny"
    (processor,) = result.cpu
    assert processor.tasks[0].activations in (49, 50)
    traffic = {bus.name: bus for bus in result.buses}
    assert traffic["spi1"].transactions == processor.tasks[0].activations


def test_an_i2c_bus_tells_its_use(board, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    request = board("on_i2c")
    description = tmp_path / "tiny" / "board.toml"
    text = description.read_text().replace('kind = "spi"', 'kind = "i2c"')
    description.write_text(text.replace("clock_hz = 5_000_000", "clock_hz = 400_000"))
    scenario = tmp_path / "tiny" / "scenarios" / "still.toml"
    scenario.write_text(STILL + '[expect]\n"buses.spi1.load" = 1e-3\nseconds_with_solution = 0')
    result = run(request)
    bus = next(bus for bus in result.buses if bus.name == "spi1")
    assert bus.transactions == result.cpu[0].tasks[0].activations
    clocks = 1 + 2 * 9 + 1 + 9 + 9 + 1  # fact sheet, section 2: address and register, address again, one byte
    assert bus.load == pytest.approx(bus.transactions * clocks / 400e3 / 5.0, rel=1e-6)
    assert result.ok


def test_task_that_never_lets_time_pass_is_named(board, monkeypatch: pytest.MonkeyPatch) -> None:  # type: ignore[no-untyped-def]
    monkeypatch.setattr(machine, "STALL_LIMIT_S", 0.5)
    with pytest.raises(SpinError, match=r"stood still at 0\.1\d* s.*'worker' on 'brain'"):
        run(board("endless"))


def test_task_that_polls_for_ever_is_named(board, monkeypatch: pytest.MonkeyPatch) -> None:  # type: ignore[no-untyped-def]
    monkeypatch.setattr(cpu, "POLL_LIMIT", 20_000)
    with pytest.raises(SpinError, match=r"'worker' on processor 'brain'.*20,000"):
        run(board("polling"))


def test_line_that_the_board_does_not_name_is_told(board) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(UserError, match=r"board\.toml.*processors\.brain\.tasks 'nobody'.*worker"):
        run(board("unknown"))
