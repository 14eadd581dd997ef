"""I²C buses in captures: every transaction as it was, in all tools, and a strict replay of them."""

import csv

import numpy as np
import pytest
from replay_captures import tampered
from typer.testing import CliRunner

from hal.errors import ErrorKind
from host.capture.blocks import I2cTransaction
from host.capture.reader import CaptureReader
from host.cli.main import app
from host.record.result import RunRequest
from host.replay.recorded_world import CaptureContent
from host.replay.request import ReplayRequest
from host.replay.setting import recorded_board
from host.replay.strict import replay_strict
from host.run.runner import run

BOARD = """
name = "two_wires"
title = "a BMI160 on I2C"
default_profile = "plain"
default_scenario = "still"

[processors.brain]
part = "STM32F405"
clock_hz = 168_000_000
program = "two_wires_program:program"
tasks = { ready = { priority = 1 }, other = { priority = 2 } }

[buses.i2c1]
kind = "i2c"
processor = "brain"
clock_hz = 400_000

[chips.U1]
part = "BMI160"
model = "boards.chips.bmi160:Bmi160"
bus = "i2c1"
name = "imu"
world = "imu"
errors = "bmi160"
pins = { INT1 = "READY" }

[pins.ready]
processor = "brain"
net = "READY"
use = "input"

[uarts.host]
processor = "brain"
baud = 115_200

[timers.tick]
processor = "brain"

[profiles.plain]
"""

PROGRAM = """
from hal.errors import BusError
from hal.pins import Edge

class Program:
    def __init__(self, io):
        self.io = io
        self.samples = 0

    def main(self):
        cpu, bus = self.io.cpu, self.io.i2c["i2c1"]
        def write(register, value):
            bus.transaction(0x68, bytes((register, value)))
            cpu.delay(1_000_000)
        write(0x7E, 0xB6)
        cpu.delay(100_000_000)
        write(0x7E, 0x11)
        cpu.delay(10_000_000)
        write(0x7E, 0x15)
        cpu.delay(100_000_000)
        write(0x41, 0x05)
        write(0x53, 0x0A)
        write(0x56, 0x80)
        write(0x51, 0x10)
        line = self.io.interrupts.attach("ready", self.read)
        self.io.inputs["ready"].interrupt_on(Edge.RISING, line)
        other = self.io.interrupts.attach("other", self.ask)
        self.io.timers["tick"].start(3, other)
        while True:
            cpu.wait_for_interrupt()

    def read(self):
        try:
            data = self.io.i2c["i2c1"].transaction(0x68, b"\\x0c", 15)
        except BusError as error:
            data = str(error).encode()
        self.samples += 1
        self.io.uart["host"].write(data)

    def ask(self):
        try:
            self.io.i2c["i2c1"].transaction(0x50, b"\\x01", 2)
        except BusError as error:
            self.io.uart["host"].write(str(error).encode())

    def spoil(self):
        pass

    def memory(self):
        return self.samples.to_bytes(4, "little")


def program(io, profile, installation):
    return Program(io)
"""

STILL = """
duration_s = 8.0
[place]
latitude_deg = 30.0
longitude_deg = 114.0
"""


@pytest.fixture(scope="module")
def captured(tmp_path_factory):
    folder = tmp_path_factory.mktemp("i2c")
    (folder / "board" / "scenarios").mkdir(parents=True)
    (folder / "board" / "scenarios" / "still.toml").write_text(STILL)
    (folder / "board" / "board.toml").write_text(BOARD)
    (folder / "board" / "two_wires_program.py").write_text(PROGRAM)
    request = RunRequest(
        str(folder / "board"), overrides=('fault=[{kind="cpu-reset",target="brain",at_s=4}]',)
    )
    result = run(RunRequest(request.board, overrides=request.overrides, out_dir=folder / "run"))
    return folder / "board", folder / "run" / "run.mcap", result


def transfers(capture):
    return [one.transfer for one in CaptureReader(capture) if isinstance(one, I2cTransaction)]


def navtwin(*arguments):
    return CliRunner().invoke(app, [str(a) for a in arguments])


def test_every_transaction_is_recorded_as_it_was(captured):
    _, capture, result = captured
    found = transfers(capture)
    (use,) = [bus for bus in result.buses if bus.name == "i2c1"]
    assert len(found) == use.transactions > 700
    first = found[0]
    # start + 9 clocks for the address and each of two bytes + stop, at 400 kHz
    assert first[1:] == (first.start_ns + 29 * 2500, 0x68, b"\x7e\xb6", 2, 0, b"", None)
    reads = [one for one in found if one.asked == 15]
    assert {one.end_ns - one.start_ns for one in reads if one.refusal is None} == {
        (1 + 18 + 10 + 135 + 1) * 2500
    }
    assert len(reads) > 600
    assert all(len(one.read) == 15 for one in reads if one.refusal is None)
    nobody = [one for one in found if one.address == 0x50]
    assert len(nobody) > 15
    assert {one[2:] for one in nobody} == {(0x50, b"\x01", 0, 2, b"", ErrorKind.ADDRESS_NACK)}


def test_it_replays_strictly_also_through_a_reset(captured):
    board, capture, result = captured
    replayed = replay_strict(ReplayRequest(capture, board=str(board)))
    assert replayed.difference is None
    assert replayed.ok
    assert replayed.state_hash == result.state_hash
    assert replayed.transactions == len(transfers(capture))


@pytest.mark.parametrize(
    ("change", "shown"),
    [
        (lambda data: data[:34] + b"\x0d" + data[35:], ("writes 0d", "writes 0c")),
        (lambda data: b"", ("/i2c/i2c1", "reads 15 bytes")),
    ],
    ids=["another register", "one less"],
)
def test_the_first_difference_is_shown(tmp_path, captured, change, shown):
    board, capture, _ = captured

    def changed(message, number, _time, data):
        return change(data) if message.topic == "/i2c/i2c1" and number == 200 else data

    other = tampered(capture, tmp_path / "x.mcap", changed)
    outcome = navtwin("replay", other, "--board", board)
    assert outcome.exit_code == 1, outcome.output
    for text in shown:
        assert text in outcome.output


def test_samples_are_decoded_as_those_on_spi_are(captured):
    _, capture, _ = captured
    reader = CaptureReader(capture)
    next(iter(reader.messages()))
    samples = CaptureContent(reader, recorded_board(reader.manifest)).samples["U1"]
    assert len(samples.times_ns) > 600
    steps = np.diff(samples.times_ns)
    assert np.median(steps) == pytest.approx(10_000_000, rel=1e-3)
    assert np.abs(steps - 10_000_000).mean() < 1e6
    # At rest and level; the sensor's turn-on bias is some 40 mg an axis.
    assert np.abs(samples.force.mean(axis=0)) == pytest.approx((0.0, 0.0, 9.8), abs=1.5)
    assert samples.force.std(axis=0).max() < 0.1
    assert np.abs(samples.rate).max() < 0.2


def test_the_tools_know_it(tmp_path, captured):
    _, capture, _ = captured
    outcome = navtwin("capture", "info", capture)
    assert "/i2c/i2c1" in outcome.output
    navtwin("capture", "export", capture, "-f", "csv", "-o", tmp_path / "t", "--topic", "/i2c/i2c1")
    rows = list(csv.DictReader((tmp_path / "t" / "i2c-i2c1.csv").open()))
    assert len(rows) == len(transfers(capture))
    assert rows[0]["written"] == "7eb6"
    assert {row["refusal"] for row in rows} >= {"", "address_nack"}
    outcome = navtwin("capture", "export", capture, "-f", "vcd", "-o", tmp_path / "x.vcd")
    assert outcome.exit_code == 0, outcome.output
    assert "i2c1_busy" in (tmp_path / "x.vcd").read_text()
    outcome = navtwin("capture", "cut", capture, "--to", "2", "-o", tmp_path / "cut.mcap")
    assert outcome.exit_code == 0
    early = [one for one in transfers(capture) if one.start_ns < 2_000_000_000]
    assert transfers(tmp_path / "cut.mcap") == early


def test_a_transaction_that_a_reset_breaks_off_is_recorded_and_replays(tmp_path, captured):
    board, capture, _ = captured
    broken = next(one for one in transfers(capture) if one.asked == 15 and one.start_ns > 6_000_000_000)
    middle_s = (broken.start_ns + broken.end_ns) / 2e9
    resets = ",".join(f'{{kind="cpu-reset",target="brain",at_s={at_s}}}' for at_s in (4, middle_s))
    result = run(RunRequest(str(board), overrides=(f"fault=[{resets}]",), out_dir=tmp_path / "run"))
    cut_short = [one for one in transfers(tmp_path / "run" / "run.mcap") if one.refusal is ErrorKind.OTHER]
    assert [one.start_ns for one in cut_short] == [broken.start_ns]
    assert 0 <= cut_short[0].end_ns - middle_s * 1e9 < 1000  # the reset takes some cycles
    replayed = replay_strict(ReplayRequest(tmp_path / "run" / "run.mcap", board=str(board)))
    assert replayed.ok, replayed.difference
    assert replayed.state_hash == result.state_hash
