"""Seven ADXL345, each on a controller of its own: their FIFOs drained each tick, and who is missing or stuck.

The chips run on clocks of their own: a tick finds none, one or two new samples in a FIFO. All are read, the
newest is used; without a new one the one before stands for it, for GRACE_TICKS at most.

Each chip is asked once a second whether its FIFO is empty behind a tick. One that never says so counts
wrongly, and what is read of it grows old: it is missing until it counts again.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from firmware.apps.gfsins.accelerations import CHIPS, compare_samples
from firmware.drivers.adxl345 import ENTRIES_MASK, FIFO_ENTRIES, Adxl345, Adxl345Config, Outcome, Register
from firmware.drivers.adxl345_ports import READ, SAMPLE_REQUEST, SpiPort
from firmware.drivers.adxl345_sample import SAMPLE_LENGTH
from firmware.numerics.dialect import entry_point
from hal.board_io import BoardIo
from hal.machine_code import mypyc_attr

RATE_HZ: Final = 200
RANGE_G: Final = 16
GRACE_TICKS: Final = 4
"""Ticks without a sample, or samples all alike, from which a chip counts as missing or stuck."""
STUCK_SAMPLES: Final = 20
LOOKS_APART: Final = 200
"""Ticks from one look whether a FIFO is empty to the next; a chip a tick."""
MOST_NEW: Final = 2
"""Samples that can come while it is looked."""
STATUS_REQUEST: Final = bytearray((READ | Register.FIFO_STATUS, 0))
BURST_REQUEST: Final = bytearray(SAMPLE_REQUEST)
"""Assigning one bytearray to another takes a third of the time of bytes."""
ALL: Final = (1 << CHIPS) - 1
WHOLE: Final = slice(None)
"""`[:]`, made once."""


@mypyc_attr(allow_interpreted_subclasses=True)
class Accelerometers:
    """The seven chips, A1 … A6 on the arms and the seventh at the origin."""

    def __init__(self, io: BoardIo) -> None:
        config = Adxl345Config(rate_hz=RATE_HZ, range_g=RANGE_G, fifo="stream")
        devices = [io.spi[f"accelerometer{k + 1}"] for k in range(CHIPS)]
        self.drivers = [Adxl345(SpiPort(device), io.cpu, config) for device in devices]
        self.missing = ALL
        """Bit k: chip k + 1 gives no samples, or has not been brought up since it gave none."""
        self.stuck = 0
        """Bit k: chip k + 1 gives the same again and again."""
        self.at_odds = 0
        """Bit k: chip k + 1 does not agree with the others."""
        self.fresh = 0
        """Bit k: chip k + 1 gave a sample at this tick."""
        self.raw = bytearray(CHIPS * SAMPLE_LENGTH)
        """The newest sample of each."""
        self.counts = [0, 0, 0, 0]
        """Reads that found none, one, two, more new samples."""
        self._miscounting = 0
        """Bit k: the FIFO of chip k + 1 is never empty."""
        self._looked = LOOKS_APART // 2
        """Half a second from when a missing chip is brought up anew."""
        self._held = 0
        """Bit k: chip k + 1 is being brought up, the tick leaves it alone."""
        self._transactions = [device.transaction for device in devices]
        self._buffers = [bytearray(SAMPLE_LENGTH) for _ in range(CHIPS)]
        self._status = bytearray(2)
        self._silent_ticks = [0] * CHIPS
        self._now = np.frombuffer(self.raw, np.uint8)
        self._before = np.zeros(len(self.raw), np.uint8)
        """The sample of each that came before, behind a byte that says whether there is one."""
        self._compare = entry_point(compare_samples)
        self._alike = [0] * CHIPS
        self._some_alike = False
        self._spend = io.cpu.spend
        self._pop_cycles = io.cpu.cost("fifo_pop")

    @property
    def faults(self) -> int:
        """Bit k: chip k + 1 is not to be believed."""
        return self.missing | self.stuck | self.at_odds

    def start(self, chip: int) -> Outcome:
        """Bring one up, from set-up or background; ticks leave it alone meanwhile."""
        bit = 1 << chip
        self._held |= bit
        outcome = self.drivers[chip].start()
        self._silent_ticks[chip] = GRACE_TICKS if outcome is not Outcome.OK else 0
        self._alike[chip] = 0
        if outcome is Outcome.OK:
            self.missing &= ~bit | self._miscounting
            self.stuck &= ~bit
        else:
            self.missing |= bit
        self._held &= ~bit
        return outcome

    def drain(self) -> None:
        """All FIFOs, at a tick."""
        status, held, fresh = self._status, self._held, 0
        counts, buffers, silent = self.counts, self._buffers, self._silent_ticks
        for chip, transaction in enumerate(self._transactions):
            if held >> chip & 1:
                continue
            status[WHOLE] = STATUS_REQUEST
            transaction(status)
            entries = status[1] & ENTRIES_MASK
            if not 0 < entries <= FIFO_ENTRIES:
                counts[0] += 1
                self._found_none(chip)
                continue
            counts[entries if entries < 3 else 3] += 1
            buffer = buffers[chip]
            while entries > 1:
                entries -= 1
                buffer[WHOLE] = BURST_REQUEST
                transaction(buffer)
                self._spend(self._pop_cycles)
            buffer[WHOLE] = BURST_REQUEST
            transaction(buffer)
            fresh |= 1 << chip
            silent[chip] = 0
        self._looked = looked = (self._looked + 1) % LOOKS_APART
        if looked < CHIPS and fresh >> looked & 1:
            self._look_whether_empty(looked)
        self.fresh = fresh & ~self.missing
        self.raw[WHOLE] = b"".join(buffers)
        alike = int(self._compare(self._now, self._before, fresh))
        if alike or self._some_alike:
            self._count_alike(alike, fresh)

    def _look_whether_empty(self, chip: int) -> None:
        """Behind its sample at this tick; what has come since is read, too."""
        status, transaction, buffer = self._status, self._transactions[chip], self._buffers[chip]
        for _ in range(MOST_NEW + 1):
            status[:] = STATUS_REQUEST
            transaction(status)
            if not status[1] & ENTRIES_MASK:
                self._miscounting &= ~(1 << chip)
                return
            buffer[:] = BURST_REQUEST
            transaction(buffer)
            self._spend(self._pop_cycles)
        self._miscounting |= 1 << chip
        self.missing |= 1 << chip

    def _found_none(self, chip: int) -> None:
        self._silent_ticks[chip] += 1
        if self._silent_ticks[chip] >= GRACE_TICKS:
            self.missing |= 1 << chip

    def _count_alike(self, alike: int, fresh: int) -> None:
        """Bits of the chips that gave the same again, and of those that gave a sample."""
        counts = self._alike
        for chip in range(CHIPS):
            if alike >> chip & 1:
                counts[chip] += 1
                if counts[chip] >= STUCK_SAMPLES:
                    self.stuck |= 1 << chip
            elif fresh >> chip & 1 and counts[chip]:
                counts[chip] = 0
                self.stuck &= ~(1 << chip)
        self._some_alike = any(counts)
