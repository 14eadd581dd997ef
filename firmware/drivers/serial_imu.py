"""The serial inertial unit (framed, RS-422): from the DMA ring to samples.

    stream = SerialImuStream(baud=230_400)
    uart.start_receive(stream.ring, line)
    def on_uart():                                    # the handler of `line`
        while stream.take(uart.received(), clock.now_ns()):
            use(stream.sample)                        # see `serial_imu_frames`

The unit talks by itself; there is nothing to set up. A silence of `gap_ns` ends a frame that was cut off.
"""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from firmware.drivers import serial_imu_frames as fr
from firmware.numerics.dialect import entry_point

BITS_PER_BYTE: Final = 10
SECOND_NS: Final = 1_000_000_000
SHORTEST_RING: Final = 128
LONG_AGO_NS: Final = -(1 << 60)
DEFAULT_GAP_NS: Final = 500_000


class SerialImuStatistics(NamedTuple):
    """What was heard since the stream was made."""

    frames: int
    lost: int
    """Samples that are missing by the counter."""
    bad_checks: int
    garbage: int
    """Bytes outside good frames."""
    overruns: int


class SerialImuStream:
    """Ring and parser state of one unit; `sample` is the latest, int64 (see `serial_imu_frames`).

    Raises ValueError for a ring that is not a power of two.
    """

    def __init__(self, ring_length: int = 512, baud: int = 230_400, gap_ns: int = DEFAULT_GAP_NS) -> None:
        if ring_length < SHORTEST_RING or ring_length & (ring_length - 1):
            raise ValueError(
                f"ring_length is {ring_length}, not a power of two of at least {SHORTEST_RING}; valid: 512"
            )
        self.ring = bytearray(ring_length)
        self.sample: NDArray[np.int64] = np.zeros(fr.SAMPLE_SIZE, np.int64)
        self.state: NDArray[np.int64] = np.zeros(fr.STATE_SIZE, np.int64)
        self.state[fr.MASK] = ring_length - 1
        self.state[fr.BYTE_NS] = BITS_PER_BYTE * SECOND_NS // baud
        self.state[fr.LAST_COUNTER] = -1
        self._view: NDArray[np.uint8] = np.frombuffer(self.ring, np.uint8)
        self._find = entry_point(fr.find_frame)
        self._gap_ns = gap_ns
        self._position = 0
        self._taken = 0
        self._last_ns = LONG_AGO_NS
        self._overruns = 0
        self._cut = 0

    def take(self, received: int, now_ns: int) -> bool:
        """Look at the bytes up to number `received` of the port; True when `sample` has just been filled:
        call again. `now_ns` is the board's clock."""
        state = self.state
        fresh = received - self._taken
        if fresh:
            byte_ns = int(state[fr.BYTE_NS])
            if received & (len(self.ring) // 2 - 1):
                now_ns -= byte_ns  # the idle line called, one byte after the last
            if now_ns - fresh * byte_ns - self._last_ns > self._gap_ns and self._look(1):
                return True
            if received - self._position > len(self.ring):
                self._overruns += 1
                self._position = received
            self._taken, self._last_ns = received, now_ns
        return self._look(0)

    def _look(self, cut: int) -> bool:
        """A frame among the bytes taken so far."""
        if self._position == self._taken:
            return False
        state = self.state
        if cut != self._cut:
            self._cut = state[fr.CUT] = cut
        self._position = self._find(
            state, self._view, self._position, self._taken, self._last_ns, self.sample
        )
        return bool(state[fr.READY])

    def statistics(self) -> SerialImuStatistics:
        """Counters since the stream was made."""
        count = self.state.tolist()
        return SerialImuStatistics(
            count[fr.FRAMES], count[fr.LOST], count[fr.BAD_CHECKS], count[fr.GARBAGE], self._overruns
        )
