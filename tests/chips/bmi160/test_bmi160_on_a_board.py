"""The chip behind an emulated processor: SPI wire time, interrupt line, one event a sample."""

from __future__ import annotations

from itertools import pairwise

from bmi160_rig import MS, BenchWorld, G

from boards.chips.bmi160 import Bmi160
from hal.emulated.cpu import EmulatedCpu
from hal.emulated.interrupt_line import LineSpec
from hal.emulated.pins import EmulatedInputPin, Net
from hal.emulated.spi import EmulatedSpiBus, SpiTiming
from hal.emulated.virtual_time import VirtualTime
from hal.pins import Edge


class Board:
    """One processor, one chip on SPI at 10 MHz, INT1 wired."""

    def __init__(self, clock_error_ppm: float) -> None:
        self.time = VirtualTime()
        self.cpu = EmulatedCpu(self.time, "mcu", 168_000_000, [LineSpec("imu", 1)])
        self.chip = Bmi160(
            self.time,
            BenchWorld(lambda t: {"fx": 0.1 * t, "fz": G, "wz": 0.02 * t}),
            clock_error_ppm=clock_error_ppm,
        )
        net = Net(self.time, "INT1")
        self.chip.pins["INT1"] = net
        self.pin = EmulatedInputPin(self.cpu, net)
        self.spi = EmulatedSpiBus(self.cpu, SpiTiming(10_000_000)).device(self.chip, "imu")
        self.bursts: list[tuple[int, bytes]] = []

    def write(self, register: int, value: int, wait_ns: int) -> None:
        self.spi.transaction(bytearray((register, value)))
        self.cpu.delay(wait_ns)

    def start(self) -> None:
        self.cpu.delay(10 * MS)
        self.spi.transaction(bytearray((0xFF, 0)))
        self.write(0x7E, 0x11, 4 * MS)
        self.write(0x7E, 0x15, 81 * MS)
        for register, value in ((0x53, 0x0A), (0x56, 0x80), (0x51, 0x10)):
            self.write(register, value, 2_000)
        self.pin.interrupt_on(Edge.RISING, self.cpu.attach("imu", self.on_data_ready))

    def on_data_ready(self) -> None:
        buffer = bytearray(16)
        buffer[0] = 0x8C
        when = self.time.now
        self.spi.transaction(buffer)
        self.bursts.append((when, bytes(buffer)))

    def run(self, samples: int) -> None:
        while len(self.bursts) < samples:
            self.cpu.wait_for_interrupt()


def test_interrupt_driven_reading() -> None:
    board = Board(clock_error_ppm=5000.0)
    board.start()
    board.run(20)
    events = board.time.events_run
    board.run(520)
    assert board.time.events_run - events == 500
    ticks = [int.from_bytes(burst[13:], "little") for _, burst in board.bursts]
    assert {b - a for a, b in pairwise(ticks[20:])} == {256}
    assert all(tick % 256 == 0 for tick in ticks[20:])  # the handler reads within one tick of the sample
    period = (board.bursts[-1][0] - board.bursts[20][0]) / 499
    assert abs(period - 10e6 / 1.005) < 1.0


def test_two_runs_are_equal() -> None:
    boards = [Board(clock_error_ppm=1234.5) for _ in range(2)]
    for board in boards:
        board.start()
        board.run(200)
    assert boards[0].bursts == boards[1].bursts
