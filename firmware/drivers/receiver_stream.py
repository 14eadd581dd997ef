"""What a GNSS receiver says on its UART, from the DMA ring to epochs.

    stream = ReceiverStream(baud=9600)
    uart.start_receive(stream.ring, line)
    def on_uart():                                    # the handler of `line`
        while stream.take(uart.received(), clock.now_ns()):
            use(stream.epoch)

`take` wants to be called from the UART's interrupt and, so that a silence is noticed, now and then from
a slower task of the same priority. Bytes are lost when a whole ring of them is unread.
"""

from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from firmware.drivers import receiver_state as st
from firmware.drivers.gnss_epoch import new_epoch
from firmware.drivers.message_table import write_tables
from firmware.drivers.receiver_demux import demultiplex
from firmware.drivers.satellite_lists import SatelliteInView, satellites
from firmware.numerics.dialect import entry_point
from hal.machine_code import mypyc_attr

BITS_PER_BYTE: Final = 10
SECOND_NS: Final = 1_000_000_000
LONG_AGO_NS: Final = -(1 << 60)
SHORTEST_RING: Final = 512
DEFAULT_GAP_NS: Final = 20_000_000
"""Receivers print an epoch without pauses, or with pauses of a few ms; the fastest epochs are 50 ms apart."""


@dataclass(frozen=True, slots=True)
class StreamStatistics:
    """What was heard since the stream was made."""

    sentences: int
    frames: int
    epochs: int
    bad_checksums: int
    overlong: int
    truncated: int
    unknown: int
    malformed: int
    garbage: int
    overruns: int


class Answers(NamedTuple):
    """Answers to configuration messages so far, and what the latest ones answered (class << 8 | id)."""

    acks: int
    ack_of: int
    naks: int
    nak_of: int


@mypyc_attr(allow_interpreted_subclasses=True)
class ReceiverStream:
    """Ring, parser state and the latest epoch of one receiver.

    `last_message` (a message type of `receiver_state`, e.g. `receiver_state.GLL`) completes an epoch without
    waiting for the silence behind the burst. Raises ValueError for a ring that is not a power of two.
    """

    def __init__(
        self,
        ring_length: int = 2048,
        baud: int = 9600,
        last_message: int | None = None,
        gap_ns: int = DEFAULT_GAP_NS,
    ) -> None:
        if ring_length < SHORTEST_RING or ring_length & (ring_length - 1):
            raise ValueError(
                f"ring_length is {ring_length}, not a power of two of at least {SHORTEST_RING}; valid: 2048"
            )
        self.ring = bytearray(ring_length)
        self.epoch: NDArray[np.int64] = new_epoch()
        self.state: NDArray[np.int64] = np.zeros(st.STATE_SIZE, np.int64)
        self._view: NDArray[np.uint8] = np.frombuffer(self.ring, np.uint8)
        self._position = 0
        self._demultiplex = entry_point(demultiplex)
        self.state[st.RING_MASK] = ring_length - 1
        self.state[st.GAP_NS] = gap_ns
        self.state[st.LONGEST_FRAME] = ring_length // 2
        self.state[st.LAST_BYTE_NS] = LONG_AGO_NS
        self.state[st.BURST_NS] = -1
        write_tables(self.state)
        self.expect_last(last_message)
        self.set_baud(baud)

    def set_baud(self, baud: int) -> None:
        """Tell the bit rate of the bytes that follow, for their times."""
        self.baud = baud
        self.state[st.BYTE_NS] = BITS_PER_BYTE * SECOND_NS // baud

    def expect_last(self, last_message: int | None) -> None:
        """Name the message type that completes an epoch, or None to wait for the silence."""
        self.state[st.LAST_MESSAGE] = -1 if last_message is None else last_message

    def take(self, received: int, now_ns: int) -> bool:
        """Parse up to byte number `received` of the port; True when `epoch` has just been filled: call again.

        `now_ns` is the board's clock in the handler. Bytes that the DMA has overwritten are counted as an
        overrun, and parsing goes on behind them.
        """
        state = self.state
        half = len(self.ring) >> 1
        taken = int(state[st.TAKEN])
        if received - self._position > len(self.ring):
            self._skip_to(received)
        elif received > taken and received & (half - 1):
            # Not at half or end of the ring: it was the idle line that called, one byte after the last.
            now_ns -= int(state[st.BYTE_NS])
        self._position = self._demultiplex(state, self._view, self._position, received, now_ns, self.epoch)
        return bool(state[st.READY])

    def _skip_to(self, received: int) -> None:
        self.state[st.OVERRUNS] += 1
        self.state[st.MODE] = st.HUNTING
        self.state[st.TAKEN] = received
        self._position = received

    def heard(self) -> int:
        """Messages with a correct checksum so far."""
        state = self.state
        return int(state[st.SENTENCES] + state[st.FRAMES] + state[st.UNKNOWN])

    def frames(self) -> int:
        """UBX frames that are understood, so far."""
        return int(self.state[st.FRAMES])

    def bytes_taken(self) -> int:
        """Bytes received so far, whatever they were."""
        return int(self.state[st.TAKEN])

    def line_errors(self) -> tuple[int, int]:
        """(messages with a wrong checksum, bytes of garbage) so far."""
        return int(self.state[st.BAD_CHECKSUMS]), int(self.state[st.GARBAGE])

    def answers(self) -> Answers:
        """What the receiver has answered to configuration messages."""
        state = self.state
        return Answers(int(state[st.ACKS]), int(state[st.ACK_OF]), int(state[st.NAKS]), int(state[st.NAK_OF]))

    def satellites(self) -> list[SatelliteInView]:
        """Satellites in view as listed last."""
        return satellites(self.state)

    def statistics(self) -> StreamStatistics:
        """Counters since the stream was made."""
        count = self.state.tolist()
        return StreamStatistics(
            sentences=count[st.SENTENCES],
            frames=count[st.FRAMES],
            epochs=count[st.DELIVERED],
            bad_checksums=count[st.BAD_CHECKSUMS],
            overlong=count[st.OVERLONG],
            truncated=count[st.TRUNCATED],
            unknown=count[st.UNKNOWN],
            malformed=count[st.MALFORMED],
            garbage=count[st.GARBAGE],
            overruns=count[st.OVERRUNS],
        )
