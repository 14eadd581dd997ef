"""The program of the FPGA: interfaces, acquisition, time stamps.

imu_receive   RS-422: frames of the inertial unit ─► samples with their time ─► DSP
timepulse     the receiver's PPS
gnss_receive  RS-232: sentences ─► epochs dated by the pulse ─► DSP
host_output   mailbox: what the DSP wants to say ─► RS-232 to the host
main          set-up of the receiver, health, watchdog
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from firmware.apps.dual_antenna import memory_map as at
from firmware.apps.dual_antenna.host_line import HostLine
from firmware.apps.dual_antenna.imu_line import ImuLine
from firmware.apps.dual_antenna.post import Post
from firmware.apps.dual_antenna.receiver_line import ReceiverLine
from firmware.apps.dual_antenna.settings import Settings
from hal.board_io import BoardIo

RATE_HZ = 10
WATCHDOG_NS = 2_000_000_000


def program(io: BoardIo, profile: Mapping[str, Any], installation: Mapping[str, Any]) -> FrontEnd:
    """The configuration of the FPGA. Raises ValueError for a profile that no program could mean."""
    Settings.of(profile)
    return FrontEnd(io)


class FrontEnd:
    """Implements `hal.board_io.Program`."""

    def __init__(self, io: BoardIo) -> None:
        at.check_memory(io.memories["exchange"])
        self._io = io
        self._ticks = 0

    def main(self) -> None:
        """From power-on or reset. Only the count of its starts survives, in the memory."""
        io = self._io
        memory = io.memories["exchange"]
        before = at.HEALTH.unpack(memory.read(at.HEALTH_AT, at.HEALTH_WORDS))
        post = Post(io, before[1] + 1)
        imu = ImuLine(io, post)
        receiver = ReceiverLine(io, post)
        host = HostLine(io)
        cost = io.cpu.cost("health")
        line = io.interrupts.attach("front_end_tick", self._on_tick)
        host.begin()
        receiver.listen()
        imu.begin()
        io.watchdog.start(WATCHDOG_NS)
        io.timers["front_end"].start(RATE_HZ, line)
        self._ticks = done = 0
        while True:
            while self._ticks == done:
                io.cpu.wait_for_interrupt()
            done = self._ticks
            io.watchdog.kick()
            receiver.service()
            host.drain()
            io.cpu.spend(cost)
            health = at.HEALTH.pack(io.clock.now_ns(), post.starts, *imu.health(), *receiver.health())
            memory.write(at.HEALTH_AT, health)

    def _on_tick(self) -> None:
        self._ticks += 1

    def spoil(self) -> None:
        """There is no navigation here."""

    def memory(self) -> bytes:
        """Nothing that navigation depends on outlives its handing over."""
        return b""
