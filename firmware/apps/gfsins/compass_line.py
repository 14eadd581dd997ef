"""The HMC6343 at the FPGA: asked ten times a second from the background, since a reading takes 2 ms.

Once a second it is looked whether it answers in time: one that is late gives readings 0.1 s old, as if new.
"""

from __future__ import annotations

from firmware.drivers.hmc6343 import Hmc6343, Hmc6343Config, Outcome
from hal.board_io import BoardIo
from hal.machine_code import mypyc_attr

RATE_HZ = 10
RETRY_LOOKS = 20
"""Looks from one attempt to bring it up to the next."""
BAD_LOOKS = 5
"""Readings in a row that failed, or were no angles, from which it is brought up anew."""
HEADINGS, TILTS = 3600, 900


@mypyc_attr(allow_interpreted_subclasses=True)
class CompassLine:
    """Owns the compass; `take` hands each reading over once."""

    def __init__(self, io: BoardIo) -> None:
        self.outcome = Outcome.ABSENT
        self.readings = 0
        self.refused = 0
        """Readings that failed, or were no angles."""
        self._driver = Hmc6343(io.i2c["compass"], io.cpu, Hmc6343Config(rate_hz=RATE_HZ))
        self._clock = io.clock
        self._looks = 0
        self._bad = 0
        self._waiting: tuple[int, int, int, int] | None = None

    @property
    def works(self) -> bool:
        """Whether there are readings to be had."""
        return self.outcome in (Outcome.OK, Outcome.LATE)

    def start(self) -> None:
        """Takes 0.6 s, or 1.1 s."""
        self.outcome = self._driver.start()
        self._bad = 0

    def look(self) -> None:
        """From the background, ten times a second."""
        self._looks += 1
        if not self.works:
            if self._looks % RETRY_LOOKS == 0:
                self.start()
            return
        angles = self._read()
        if angles is None:
            self.refused += 1
            self._bad += 1
            if self._bad >= BAD_LOOKS:
                self.outcome = self._driver.check()
                self._bad = 0
            return
        self._bad = 0
        self.readings += 1
        now_ns = self._clock.now_ns()
        if self._looks % RATE_HZ == 0 and not self._is_prompt():
            return
        self._waiting = (*angles, now_ns)

    def _is_prompt(self) -> bool:
        """Whether the last reading is a new one."""
        self.outcome = self._driver.check_promptness()
        return self.outcome is Outcome.OK

    def take(self) -> tuple[int, int, int, int] | None:
        """Heading, pitch, roll in tenths of a degree and the time of the reading, once."""
        found, self._waiting = self._waiting, None
        return found

    def field(self) -> tuple[int, ...] | None:
        """Counts of the magnetometer along x, y, z, now; takes 4 ms."""
        found = self._driver.vectors()
        return None if found is None else found[1]

    def _read(self) -> tuple[int, int, int] | None:
        if not self._driver.read():
            return None
        raw = self._driver.raw.tobytes()
        heading, pitch, roll = (int.from_bytes(raw[k : k + 2], "big", signed=True) for k in (0, 2, 4))
        good = 0 <= heading <= HEADINGS and abs(pitch) <= TILTS and abs(roll) <= TILTS
        return (heading % HEADINGS, pitch, roll) if good else None
