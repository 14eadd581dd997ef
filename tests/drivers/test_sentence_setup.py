"""Set-up of receivers that take sentences: GR-87 and the two-antenna receiver on the wire."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest
from receiver_bench import World

from boards.chips.dual_antenna import DualAntennaReceiver
from boards.chips.gr87 import Gr87
from boards.chips.world import BaselineSolution, GnssEpoch
from firmware.drivers import gnss_epoch as ge
from firmware.drivers.dual_antenna import DualAntennaSetup
from firmware.drivers.gnss_epoch import as_dict
from firmware.drivers.gr87 import Gr87Setup
from firmware.drivers.receiver_stream import ReceiverStream
from firmware.drivers.sentence_setup import SentenceConfigurator, SetupPhase
from hal.emulated.cpu import EmulatedCpu
from hal.emulated.faults import UartCut
from hal.emulated.interrupt_line import LineSpec
from hal.emulated.uart import EmulatedUart
from hal.emulated.uart_wire import UartWire
from hal.emulated.virtual_time import SECOND, VirtualTime

BASELINE = BaselineSolution("FIXED", math.radians(200.5), math.radians(2.25), 2.0, 0.001, 0.002, 0.005)


class TwoAntennas(World):
    """The same drive with a second antenna."""

    def epoch(self, time_ns: int) -> GnssEpoch:
        return replace(super().epoch(time_ns), baseline=BASELINE)


class Bench:
    """Chip, wires, port, stream and set-up; `run` plays interrupt and background."""

    def __init__(self, chip: Any, setup: Any, first_baud: int, **parameters: Any) -> None:
        self.time = VirtualTime()
        self.to_board = UartWire(self.time, first_baud, "gnss to board")
        self.to_chip = UartWire(self.time, first_baud, "board to gnss", capacity=1024)
        self.cpu = EmulatedCpu(self.time, "mcu", 70_000_000, [LineSpec("gnss", 1)])
        self.uart = EmulatedUart(self.cpu, self.to_chip, self.to_board, "gnss")
        self.chip = chip(self.time, TwoAntennas(), self.to_board, start_state="hot", **parameters)
        self.to_chip.connect(self.chip, rate_of=self.to_board)
        self.stream = ReceiverStream(baud=first_baud)
        self.setup = SentenceConfigurator(self.uart, self.stream, setup)
        self.epochs: list[dict[str, int]] = []
        self.line = self.cpu.attach("gnss", self._take)
        self.uart.start_receive(self.stream.ring, self.line)

    def _take(self) -> None:
        while self.stream.take(self.uart.received(), self.cpu.now_ns()):
            self.epochs.append(as_dict(self.stream.epoch))

    def run(self, seconds: float) -> None:
        """Let time pass, the background at 10 Hz."""
        for _ in range(round(seconds * 10)):
            self.cpu.delay(SECOND // 10)
            self.setup.step(self.cpu.now_ns())
            self.line.pend()


@pytest.mark.parametrize("found_at", [4800, 19_200, 9600, 57_600])
def test_gr87_is_found_at_any_rate_and_switched(found_at: int) -> None:
    bench = Bench(Gr87, Gr87Setup(), 4800, baud=found_at)
    bench.run(45.0)
    assert (bench.setup.phase, bench.setup.baud, bench.chip.baud) == (SetupPhase.RUNNING, 19_200, 19_200)
    bench.epochs.clear()
    bench.run(5.0)
    assert len(bench.epochs) in (4, 5)
    epoch = bench.epochs[-1]
    wanted = ge.HAS_TIME | ge.HAS_DATE | ge.HAS_POSITION | ge.HAS_HEIGHT | ge.HAS_SPEED | ge.HAS_COURSE
    assert epoch["flags"] & wanted == wanted
    assert epoch["lat_nanodeg"] == pytest.approx(48e9, abs=1000)
    assert epoch["height_msl_mm"] == 453_000
    assert bench.chip.reports == []


def test_gr87_is_brought_back_from_the_binary_protocol() -> None:
    bench = Bench(Gr87, Gr87Setup(), 4800)
    bench.chip.power(False)
    bench.chip.power(True)
    bench.run(1.0)
    bench.chip.receive(b"$PSRF100,0,38400,8,1,0*3C\r\n", bench.time.now)
    bench.run(90.0)
    assert (bench.setup.phase, bench.chip.baud) == (SetupPhase.RUNNING, 19_200)
    assert bench.epochs[-1]["flags"] & ge.HAS_POSITION


def test_two_antennas_give_heading_and_pitch() -> None:
    bench = Bench(DualAntennaReceiver, DualAntennaSetup(), 19_200)
    bench.run(25.0)
    assert (bench.setup.phase, bench.chip.baud, bench.chip.reports) == (SetupPhase.RUNNING, 38_400, [])
    epoch = bench.epochs[-1]
    wanted = ge.HAS_POSITION | ge.HAS_DATE | ge.HAS_ACCURACY | ge.HAS_HEADING | ge.HAS_PITCH
    assert (
        epoch["flags"] & (wanted | ge.HAS_ATTITUDE_ACCURACY | ge.HAS_ROLL)
        == wanted | ge.HAS_ATTITUDE_ACCURACY
    )
    assert (epoch["heading_e5deg"], epoch["pitch_e5deg"]) == (20_050_000, 225_000)
    assert epoch["heading_sigma_e5deg"] == 5_700
    assert epoch["h_acc_mm"] == pytest.approx(1200, abs=10)


@pytest.mark.parametrize(
    ("chip", "setup", "baud"), [(Gr87, Gr87Setup(), 4800), (DualAntennaReceiver, DualAntennaSetup(), 19_200)]
)
def test_a_receiver_that_forgets_is_set_up_again(chip: Any, setup: Any, baud: int) -> None:
    bench = Bench(chip, setup, baud, **({"backup_supply": False} if chip is Gr87 else {}))
    bench.run(20.0)
    assert bench.setup.setups == 1
    bench.chip.power(False)
    bench.run(1.0)
    bench.chip.power(True)
    bench.run(60.0)
    assert bench.setup.setups >= 2
    assert bench.chip.baud == setup.baud


def test_a_cut_line_is_noticed() -> None:
    bench = Bench(Gr87, Gr87Setup(), 4800)
    bench.run(20.0)
    UartCut(bench.time.now, bench.time.now + 20 * SECOND).install(bench.to_board)
    bench.run(10.0)
    assert bench.setup.phase is SetupPhase.LISTENING
    bench.run(40.0)
    assert bench.setup.phase is SetupPhase.RUNNING


def test_the_public_strings() -> None:
    assert Gr87Setup().port() == b"$PSRF100,1,19200,8,1,0*38\r\n"
    assert Gr87Setup(baud=4800).port() == b"$PSRF100,1,4800,8,1,0*0E\r\n"
    assert b"$PSRF103,04,00,01,01*21\r\n" in Gr87Setup().rates()


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: Gr87Setup(baud=1), "receiver baud is 1"),
        (lambda: Gr87Setup(periods_s={"XYZ": 1}), "receiver sentence 'XYZ'"),
        (lambda: DualAntennaSetup(baud=1), "receiver baud is 1"),
        (lambda: DualAntennaSetup(rates_hz={"GGA": 3}), "at 3 Hz"),
    ],
)
def test_what_cannot_be_is_refused(make: Any, text: str) -> None:
    with pytest.raises(ValueError, match=text):
        make()
