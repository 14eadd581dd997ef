"""The DSP's end of the packets: slips and wrong bits are seen, gaps counted, times put on the DSP's clock.

After a wrong packet reception begins anew with the next one that is sent: a word lost costs two packets at
most. The FPGA's sync line dates each tick; without it a packet's arrival does.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np

from firmware.nav.gyro_free import packet as pk
from firmware.numerics.dialect import entry_point
from hal.board_io import BoardIo
from hal.machine_code import mypyc_attr

PACKETS_IN_RING: Final = 2
RING: Final = PACKETS_IN_RING * pk.BYTES
TICK_TO_PACKET_NS: Final = 560_000
"""From a tick to the interrupt of its packet."""
LONGEST_CHAIN_NS: Final = 4_000_000
"""An edge of the sync line longer ago is not that of the packet that came."""
WORD_MASK: Final = 0xFFFF
NEVER_NS: Final = -(10**15)


@mypyc_attr(allow_interpreted_subclasses=True)
class Reception:
    """Owns the receiver. `take` is called with each good packet's words in `words`, their time on the DSP's
    clock, in the task `navigation`."""

    def __init__(self, io: BoardIo) -> None:
        self.words = np.zeros(pk.WORDS, np.int64)
        self.good = 0
        self.lost = 0
        """By their sequence numbers."""
        self.bad = [0, 0, 0, 0]
        """By what `open_packet` says of them."""
        self.overtaken = 0
        """Packets that came while the one before waited for the task."""
        self.restarts = 0
        """Sequence numbers that went back: the FPGA has begun anew."""
        self.gap_ns = NEVER_NS
        """When packets were found missing last."""
        self.synced = True
        """Whether the sync line dated the last packet."""
        self.tick_ns = 0
        """Of the packet in `words`, on the DSP's clock."""
        self.other: Callable[[bytes], bool] | None = None
        """Is given each packet of another kind, and says whether it knows it."""
        self._receiver = io.packet_receivers["packets"]
        self._interrupts = io.interrupts
        self._clock = io.clock
        self._cpu = io.cpu
        self._open = entry_point(pk.open_packet_at)
        self._open_cost = io.cpu.cost("open_packet")
        self._ring = bytearray(RING)
        self._bytes = np.frombuffer(self._ring, np.uint8)
        self.numbers = self.words.data
        """The same memory as `words`: a number of it in a fifth of the time."""
        self._memory = self.words.data.cast("B")
        self._taken = 0
        self._sequence = -1
        self._fpga_us = 0
        self._edges = 0
        self._sync = io.captures.get("tick")
        self._line = io.interrupts.attach("packet", self._on_packet)
        self._waiting = False

    def begin(self, take: Callable[[], None]) -> None:
        """Receive from now on."""
        self._task = self._interrupts.attach("navigation", self._on_task)
        self._take = take
        if self._sync is not None:
            self._sync.start()
        self._anew()

    def _anew(self) -> None:
        self._taken = 0
        self._receiver.begin(self._ring, pk.BYTES, self._line)

    def _on_packet(self) -> None:
        """The interrupt when a packet is whole."""
        now_ns = self._clock.now_ns()
        received = self._receiver.received()
        place = (received // pk.BYTES - 1) * pk.BYTES
        if place < self._taken:
            return
        self._taken = place + pk.BYTES
        start = place % RING
        if self._waiting:
            self.overtaken += 1
            return
        found: int = self._open(self._bytes, start, self.words)
        other = bytes(self._ring[start : start + pk.BYTES]) if found == pk.WRONG_KIND else b""
        self._cpu.spend(self._open_cost)
        if other and self.other is not None and self.other(other):
            return
        if found != pk.GOOD:
            self.bad[found] += 1
            self._anew()
            return
        self._count(now_ns)
        self._waiting = True
        self._task.pend()

    def _count(self, now_ns: int) -> None:
        sequence, high, middle, low = pk.HEADER.unpack_from(self._memory, pk.HEADER_AT)
        fpga_us = high << 32 | middle << 16 | low
        if fpga_us <= self._fpga_us:
            self.restarts += 1
            self.gap_ns = now_ns
        elif self._sequence >= 0 and sequence != self._sequence + 1 & WORD_MASK:
            self.lost += (sequence - self._sequence - 1) & WORD_MASK
            self.gap_ns = now_ns
        self._sequence, self._fpga_us = sequence, fpga_us
        self.good += 1
        self.tick_ns = tick_ns = max(self._dated(now_ns), self.tick_ns + 1000)
        tick_us = tick_ns // 1000
        high, middle, low = tick_us >> 32, tick_us >> 16 & WORD_MASK, tick_us & WORD_MASK
        pk.STAMP.pack_into(self._memory, pk.STAMP_AT, high, middle, low)

    def _dated(self, now_ns: int) -> int:
        """When the tick of the packet that has just come was."""
        if self._sync is not None:
            edges, edge_ns = self._sync.captured()
            if edges != self._edges and now_ns - edge_ns < LONGEST_CHAIN_NS:
                self._edges = edges
                self.synced = True
                return edge_ns
            self.synced = False
        return now_ns - TICK_TO_PACKET_NS

    def _on_task(self) -> None:
        self._take()
        self._waiting = False
