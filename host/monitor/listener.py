"""Bytes of a port to messages: frames of our link, or what a plain receiver says (NMEA, UBX NAV-PVT).

Which of both it is shows by itself. As long as no frame has come, the firmware's own receiver parser listens
too, and its epochs and satellites are given out as the board would have told them; the first frame ends that.
A board prints sentences of its own beside its frames: those are no second receiver.
"""

from __future__ import annotations

from firmware.drivers import gnss_epoch as epoch
from firmware.drivers.receiver_stream import ReceiverStream
from firmware.link import frames
from host.link.decoder import LinkDecoder
from host.link.messages import Gnss, Message, Satellites

BEFORE_A_GUESS = 600
"""Bytes without a frame, the longest of which is 262, after which a receiver is thought of."""
PIECE = 256
"""Bytes given to the parser at a time; half its smallest ring."""
PAUSE_NS = 40_000_000
"""Between two epochs; a computer's own scheduling makes shorter ones."""
FIX_QUALITIES = {2: "DGNSS", 4: "RTK fixed", 5: "RTK float", 6: "dead reckoning"}
FIX_TYPES = {1: "no fix", 2: "2D", 3: "3D"}


class Listener:
    """Feed bytes, get messages. `decoder` counts what it understands of the link."""

    def __init__(self, decoder: LinkDecoder) -> None:
        self._decoder = decoder
        self._receiver: Receiver | None = None
        self._early = bytearray()
        self.baud = 9600
        """Of the line, as far as it is known: tells pauses between bytes from long bursts."""

    @property
    def receiver(self) -> Receiver | None:
        """The plain receiver, once one was heard and no frame of the link."""
        heard = self._receiver is not None and self._receiver.heard > 0 and self._decoder.frames == 0
        return self._receiver if heard else None

    @property
    def understood(self) -> int:
        """Messages of any kind that made sense so far."""
        decoder = self._decoder
        heard = self._receiver.heard if self._receiver is not None and decoder.frames == 0 else 0
        return decoder.frames + max(decoder.sentences, heard)

    def feed(self, data: bytes, at_s: float) -> list[tuple[int, Message]]:
        """Messages completed by `data`, which came at `at_s`."""
        messages = self._decoder.feed(data)
        if self._decoder.frames:
            self._early.clear()
            return messages
        if self._receiver is None:
            self._early += data
            if len(self._early) < BEFORE_A_GUESS:
                return messages
            self._receiver = Receiver(self.baud)
            data = bytes(self._early)
            self._early.clear()
        return messages + self._receiver.feed(data, at_s)


class Receiver:
    """A receiver on a wire of its own."""

    def __init__(self, baud: int) -> None:
        self._stream = ReceiverStream(baud=baud, gap_ns=PAUSE_NS)
        self._received = 0
        self.fix_name: str | None = None

    @property
    def heard(self) -> int:
        """Messages with a correct checksum."""
        return self._stream.heard()

    @property
    def bad_checksums(self) -> int:
        """Messages with a wrong one."""
        return self._stream.line_errors()[0]

    @property
    def garbage_bytes(self) -> int:
        """Bytes that belong to no message."""
        return self._stream.line_errors()[1]

    def feed(self, data: bytes, at_s: float) -> list[tuple[int, Message]]:
        """GNSS and SATELLITES of each epoch that `data` completes."""
        stream = self._stream
        ring = stream.ring
        messages: list[tuple[int, Message]] = []
        now_ns = int(at_s * 1e9)
        for begin in range(0, len(data) or 1, PIECE):
            for byte in data[begin : begin + PIECE]:
                ring[self._received % len(ring)] = byte
                self._received += 1
            while stream.take(self._received, now_ns):
                messages += self._epoch(now_ns // 1000)
        return messages

    def _epoch(self, time_us: int) -> list[tuple[int, Message]]:
        e = self._stream.epoch.tolist()
        quality, kind = e[epoch.FIX_QUALITY], e[epoch.FIX_TYPE]
        self.fix_name = FIX_QUALITIES.get(quality) or FIX_TYPES.get(kind)
        gnss = Gnss(
            time_us,
            e[epoch.TIME_OF_DAY_MS] if e[epoch.FLAGS] & epoch.HAS_TIME else frames.NO_TIME_OF_DAY,
            e[epoch.DATE_DAYS] if e[epoch.FLAGS] & epoch.HAS_DATE else frames.NO_DATE,
            e[epoch.FLAGS],
            e[epoch.LAT_NANODEG],
            e[epoch.LON_NANODEG],
            e[epoch.HEIGHT_MM],
            e[epoch.HEIGHT_MSL_MM],
            e[epoch.SPEED_MMPS],
            e[epoch.COURSE_E5DEG],
            e[epoch.VEL_N_MMPS],
            e[epoch.VEL_E_MMPS],
            e[epoch.VEL_D_MMPS],
            e[epoch.SATELLITES],
            e[epoch.HDOP_CENTI],
            e[epoch.H_ACC_MM],
            e[epoch.V_ACC_MM],
        )
        seen = tuple(self._stream.satellites())
        return [(frames.GNSS, gnss), (frames.SATELLITES, Satellites(time_us, 0, 1, seen))]
