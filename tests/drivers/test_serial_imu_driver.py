"""The serial unit's driver on the wire: against the model, the transcript, and lines that went wrong."""

from __future__ import annotations

import struct
from pathlib import Path

import crcmod.predefined
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from boards.chips.serial_imu import SerialImu
from firmware.drivers import serial_imu_frames as fr
from firmware.drivers.serial_imu import SerialImuStream
from hal.emulated.cpu import EmulatedCpu
from hal.emulated.faults import UartBitErrors, UartByteDuplication, UartByteLoss, UartCut, UartGarbage
from hal.emulated.interrupt_line import LineSpec
from hal.emulated.uart import EmulatedUart
from hal.emulated.uart_wire import UartWire
from hal.emulated.virtual_time import SECOND, VirtualTime

MS = 1_000_000
TRANSCRIPT = Path(__file__).parent.parent / "chips/serial_imu/serial_imu_golden.txt"
crc = crcmod.predefined.mkCrcFun("crc-ccitt-false")


def frame(counter: int, counts: tuple[int, ...] = (1, -2, 3, -4, 5, -6), status: int = 0) -> bytes:
    body = struct.pack("<H6iH", counter, *counts, status)
    return b"\xaa\x55" + body + struct.pack("<H", crc(body))


class Line:
    """Bytes into the ring as DMA puts them, the handler called at each idle line."""

    def __init__(self, baud: int = 230_400) -> None:
        self.stream = SerialImuStream(baud=baud)
        self.byte_ns = 10 * SECOND // baud
        self.received = 0
        self.now = 0
        self.samples: list[list[int]] = []

    def send(self, data: bytes, pause_ns: int = 3_600_000) -> None:
        for value in data:
            self.stream.ring[self.received % 512] = value
            self.received += 1
            self.now += self.byte_ns
            if self.received % 256 == 0:
                self._handle(self.now)
        self._handle(self.now + (self.byte_ns if self.received % 256 else 0))
        self.now += pause_ns

    def _handle(self, now: int) -> None:
        while self.stream.take(self.received, now):
            self.samples.append(self.stream.sample.tolist())


class Bench:
    """Chip, wire, port and driver."""

    def __init__(self, world: object, **chip: object) -> None:
        self.time = VirtualTime()
        self.wire = UartWire(self.time, 230_400, "imu")
        self.cpu = EmulatedCpu(self.time, "dsp", 300_000_000, [LineSpec("imu", 1)])
        out = UartWire(self.time, 230_400, "out", capacity=64)
        self.port = EmulatedUart(self.cpu, out, self.wire, "imu")
        self.chip = SerialImu(self.time, world, self.wire, **chip)
        self.stream = SerialImuStream()
        self.samples: list[list[int]] = []
        self.port.start_receive(self.stream.ring, self.cpu.attach("imu", self._take))

    def _take(self) -> None:
        while self.stream.take(self.port.received(), self.cpu.now_ns()):
            self.samples.append(self.stream.sample.tolist())


class Turning:
    def sample(self, times_ns, bandwidth_hz):
        return np.tile([1.0, 2.0, -9.80665, 0.1, -0.2, 0.3, 25.0], (len(times_ns), 1))


def test_the_models_frames_arrive_with_their_times() -> None:
    bench = Bench(Turning())
    bench.cpu.delay(2 * SECOND)
    assert [s[fr.COUNTER] for s in bench.samples] == list(range(len(bench.samples)))
    assert len(bench.samples) == 300
    for n, sample in enumerate(bench.samples):
        # the last bit: the period's end, 0.1 ms, 320 bits
        assert abs(sample[fr.END_NS] - ((500 + 5 * n) * MS + 100_000 + 320 * SECOND // 230_400)) < 1000
        assert sample[fr.ANGLE : fr.ANGLE + 3] == [500_000, -1_000_000, 1_500_000]
        assert sample[fr.VELOCITY : fr.VELOCITY + 2] == [500_000, 1_000_000]
    assert bench.stream.statistics() == (300, 0, 0, 0, 0)
    assert bench.samples[0][fr.STATUS] == fr.STARTING
    assert bench.samples[-1][fr.STATUS] == 0


def test_it_reads_the_transcript() -> None:
    line = Line()
    for row in TRANSCRIPT.read_text().splitlines():
        line.send(bytes.fromhex(row.split(" ", 1)[1]))
    assert len(line.samples) == 12
    out = np.zeros(6, np.float32)
    for n, sample in enumerate(line.samples):
        fr.increments(np.array(sample), out)
        middle = (500 + 5 * n - 2.5) * 1e-3
        expected = [5e-4, -5e-3 * middle, 0.0, 5e-3 * np.sin(middle), 0.0, -9.80665 * 5e-3]
        assert out == pytest.approx(expected, abs=2e-8)


def test_a_lost_frame_is_counted_and_told_with_the_next() -> None:
    line = Line()
    for counter in (65_533, 65_534, 1, 2):
        line.send(frame(counter))
    assert [s[fr.MISSED] for s in line.samples] == [0, 0, 2, 0]
    assert line.stream.statistics().lost == 2


def test_numbers_at_their_ends() -> None:
    line = Line()
    line.send(frame(7, (2**31 - 1, -(2**31), 0, -1, 1, 0x55AA), 0xFFFF))
    assert line.samples[0][: fr.STATUS + 1] == [7, 2**31 - 1, -(2**31), 0, -1, 1, 0x55AA, 0xFFFF]


def test_what_is_cut_off_does_not_take_the_next_frame_with_it() -> None:
    line = Line()
    line.send(frame(0))
    line.send(frame(1)[:20])
    first = line.now
    line.send(frame(2))
    line.send(frame(3))
    assert [s[fr.COUNTER] for s in line.samples] == [0, 2, 3]
    assert line.samples[1][fr.END_NS] == first + 32 * line.byte_ns
    assert line.stream.statistics().garbage == 20


def test_a_sync_in_garbage_and_in_data_is_no_frame() -> None:
    line = Line()
    line.send(b"\xaa\x55\xaa\xaa\x55" + frame(0, (0x55AA, 0x55AA55AA, 0x55AA, 0, 0, 0)))
    line.send(frame(1))
    assert [s[fr.COUNTER] for s in line.samples] == [0, 1]


@settings(max_examples=60, deadline=None)
@given(st.lists(st.one_of(st.binary(max_size=70), st.integers(0, 65_535)), max_size=12))
def test_whole_frames_are_found_among_anything(pieces: list) -> None:
    """Behind a silence every good frame counts; noise makes none up (a CRC of 16 bits aside)."""
    line = Line()
    sent = []
    for piece in pieces:
        if isinstance(piece, int):
            sent.append(piece)
            line.send(frame(piece))
        else:
            line.send(piece)
    line.send(frame(1))
    assert [s[fr.COUNTER] for s in line.samples] == [*sent, 1]


@pytest.mark.parametrize("kind", ["cut", "errors", "loss", "doubles", "noise"])
def test_faults_on_the_line(kind: str) -> None:
    bench = Bench(Turning())
    start, end = 1 * SECOND, 2 * SECOND
    fault = {
        "cut": lambda: UartCut(start, end),
        "errors": lambda: UartBitErrors(start, end, 1e-3, 1, "imu"),
        "loss": lambda: UartByteLoss(start, end, 1e-2, 1, "imu"),
        "doubles": lambda: UartByteDuplication(start, end, 1e-2, 1, "imu"),
        "noise": lambda: UartGarbage(start, 20_000, 1, "imu"),
    }[kind]()
    fault.install(bench.wire)
    bench.cpu.delay(3 * SECOND)
    told = bench.stream.statistics()
    assert fault.fired > 0
    assert told.lost == 500 - told.frames > 5
    good = [[500_000, -1_000_000, 1_500_000, 500_000, 1_000_000]] * len(bench.samples)
    assert [s[fr.ANGLE : fr.VELOCITY + 2] for s in bench.samples] == good
    after = [s[fr.COUNTER] for s in bench.samples if s[fr.END_NS] > 2_050 * MS]
    assert after == list(range(after[0], 500))
    assert after[0] <= 311


def test_a_ring_overrun_is_counted() -> None:
    line = Line()
    line.send(frame(0))
    line.received += 5000
    line.send(frame(9))
    line.send(frame(10))
    assert line.stream.statistics().overruns == 1
    assert line.samples[-1][fr.COUNTER] == 10


def test_the_ring_is_a_power_of_two() -> None:
    with pytest.raises(ValueError, match="ring_length is 100"):
        SerialImuStream(ring_length=100)
