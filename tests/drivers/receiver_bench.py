"""A processor's port wired to the NEO-M8N chip model, and the driver's stream and set-up behind it."""

import math
from typing import Any

from boards.chips.neo_m8n import NeoM8n
from boards.chips.world import GnssEpoch, Satellite
from firmware.drivers.gnss_epoch import as_dict
from firmware.drivers.neo_m8n import Configurator, Phase, ReceiverSetup
from firmware.drivers.receiver_stream import ReceiverStream
from hal.emulated.cpu import EmulatedCpu
from hal.emulated.interrupt_line import LineSpec
from hal.emulated.uart import EmulatedUart
from hal.emulated.uart_wire import UartWire
from hal.emulated.virtual_time import SECOND, VirtualTime

STEP_NS = 100_000_000
GPS_START_NS = 2305 * 604_800 * SECOND + 18 * SECOND
SKY = (
    *(
        Satellite("GPS", number, math.radians(10 * number), math.radians(30 * number), 40.0, True)
        for number in range(1, 8)
    ),
    Satellite("GLONASS", 67, 0.5, 1.0, 30.0, True),
)


class World:
    """Driving north at 10 m/s."""

    def epoch(self, time_ns: int) -> GnssEpoch:
        """The solution at `time_ns`."""
        return GnssEpoch(
            fix=True, time_known=True, gps_time_ns=GPS_START_NS + time_ns, leap_seconds=18,
            latitude=math.radians(48.0), longitude=math.radians(-11.0), height=500.0, geoid_separation=47.0,
            velocity_ned=(10.0, 0.0, -0.5), h_acc=1.2, v_acc=2.0, s_acc=0.1, pdop=1.5, hdop=0.9, vdop=1.2,
            tdop=0.9, satellites=SKY, latency_ns=80_000_000,
        )  # fmt: skip


class ReceiverBench:
    """Chip, wires, port, stream and set-up; `run` plays interrupt and background."""

    def __init__(self, setup: ReceiverSetup | None, **chip: Any) -> None:
        self.time = VirtualTime()
        self.to_board = UartWire(self.time, 9600, "gnss to board")
        self.to_chip = UartWire(self.time, 9600, "board to gnss", capacity=512)
        self.cpu = EmulatedCpu(self.time, "mcu", 168_000_000, [LineSpec("gnss", 1), LineSpec("tick", 2)])
        self.uart = EmulatedUart(self.cpu, self.to_chip, self.to_board, "gnss")
        self.chip = NeoM8n(self.time, World(), self.to_board, start_state="hot", **chip)
        self.to_chip.connect(self.chip, rate_of=self.to_board)
        self.stream = ReceiverStream(baud=9600)
        self.setup = Configurator(self.uart, self.stream, setup)
        self.epochs: list[dict[str, int]] = []
        self.line = self.cpu.attach("gnss", self._take)
        self.uart.start_receive(self.stream.ring, self.line)

    def _take(self) -> None:
        now_ns = self.cpu.now_ns()
        while self.stream.take(self.uart.received(), now_ns):
            self.epochs.append(as_dict(self.stream.epoch))

    def run(self, seconds: float) -> None:
        """Let time pass, the background at 10 Hz."""
        for _ in range(round(seconds * SECOND / STEP_NS)):
            self.cpu.delay(STEP_NS)
            self.setup.step(self.cpu.now_ns())
            self.line.pend()

    def run_until(self, phase: Phase, limit_s: float) -> float:
        """Run until the set-up is in `phase`; seconds that it took. AssertionError after `limit_s`."""
        begin = self.time.now
        while self.setup.phase is not phase:
            self.run(0.1)
            assert self.time.now - begin <= limit_s * SECOND, f"still {self.setup.phase} after {limit_s} s"
        return (self.time.now - begin) / SECOND
