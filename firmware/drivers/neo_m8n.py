"""NEO-M8N set-up over its UART: find its bit rate, configure it, notice when it has forgotten (fact sheet
sections 1 and 4).

    listening ──something valid──► configuring ──all acknowledged──► running
        ▲  └─ garbage: next bit rate       │ no answer                  │ nothing valid, or not
        └──────────────────────────────────┴────────────────────────────┘ what was asked for

`step` never waits: the background calls it now and then, each call looks at what the stream has heard and
at the clock, and sends at most one message. One message is on its way at a time; it is sent again when it
is not acknowledged within ANSWER_NS (the receiver promises 1 s, and its answer queues behind a burst).

The bit rate changes first. The acknowledgement of CFG-PRT may still come at the old rate or already at the
new one, so it is not waited for: the new rate counts when the receiver is understood at it.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from struct import pack
from typing import Final

from firmware.drivers import receiver_state as st
from firmware.drivers.receiver_stream import SECOND_NS, Answers, ReceiverStream
from firmware.drivers.ubx import frame
from hal.machine_code import mypyc_attr
from hal.uart import Uart

CFG_PRT: Final = 0x0600
CFG_MSG: Final = 0x0601
CFG_RATE: Final = 0x0608
CFG_NAV5: Final = 0x0624
CFG_GNSS: Final = 0x063E
MON_VER: Final = 0x0A04

BAUD_RATES: Final = (9600, 115200, 38400, 57600, 19200, 230400, 4800)
"""In the order in which they are tried: the receiver's default first."""
ANSWER_NS: Final = 2 * SECOND_NS
ATTEMPTS: Final = 3
SETTLE_NS: Final = SECOND_NS
"""From CFG-PRT to the first question at the new rate, and between questions: a burst and the answer."""
GARBAGE_NS: Final = 1_200_000_000
"""Bytes come for so long without a valid message: the bit rate is wrong. A burst comes every second."""
NOISE_BYTES: Final = 10
POLL_NS: Final = 2 * SECOND_NS
"""A receiver that says nothing is asked who it is so often."""
SILENT_NS: Final = 10 * SECOND_NS
"""After so long without bytes another bit rate is tried, too."""
FORGOTTEN_NS: Final = 3 * SECOND_NS
"""So long without what was asked for: the receiver was reset, or the cable is off."""

MODE_8N1: Final = 0x08D0
IN_PROTOCOLS: Final = 0x0007
OUT_PROTOCOLS: Final = 0x0003
UART1: Final = 1
TIME_OF_GPS: Final = 1
DYNAMIC_MODELS: Final = {"portable": 0, "stationary": 2, "pedestrian": 3, "automotive": 4, "sea": 5}
DYNAMIC_MODEL_ONLY: Final = 0x0001
FASTEST_OF_MANY_HZ: Final = 5
"""With more than one satellite system; above it GPS navigates alone (with SBAS and QZSS)."""

NMEA: Final = {"GGA": 0xF000, "GLL": 0xF001, "GSA": 0xF002, "GSV": 0xF003, "RMC": 0xF004, "VTG": 0xF005}
NAV_PVT: Final = 0x0107


@dataclass(frozen=True)
class ReceiverSetup:
    """What the receiver is asked for: NAV-PVT every epoch, GSA and GSV once a second for displays.

    Raises ValueError for what the receiver cannot do.
    """

    baud: int = 115200
    rate_hz: int = 1
    dynamic_model: str = "automotive"

    def __post_init__(self) -> None:
        if self.baud not in BAUD_RATES:
            raise ValueError(f"receiver baud is {self.baud!r}; possible: {', '.join(map(str, BAUD_RATES))}")
        if self.rate_hz not in (1, 2, 4, 5, 8, 10):
            raise ValueError(f"receiver rate_hz is {self.rate_hz!r}; possible: 1, 2, 4, 5, 8, 10")
        if self.dynamic_model not in DYNAMIC_MODELS:
            known = ", ".join(DYNAMIC_MODELS)
            raise ValueError(f"receiver dynamic_model is {self.dynamic_model!r}; possible: {known}")

    def port(self) -> bytes:
        """CFG-PRT for UART 1: 8N1 at the wanted rate, UBX, NMEA and RTCM in, UBX and NMEA out."""
        payload = pack("<BBHIIHHHH", UART1, 0, 0, MODE_8N1, self.baud, IN_PROTOCOLS, OUT_PROTOCOLS, 0, 0)
        return frame(CFG_PRT, payload)

    def messages(self) -> tuple[bytes, ...]:
        """The frames behind CFG-PRT, in order; each is acknowledged."""
        model = pack("<HB33x", DYNAMIC_MODEL_ONLY, DYNAMIC_MODELS[self.dynamic_model])
        systems = (frame(CFG_GNSS, _gps_alone()),) if self.rate_hz > FASTEST_OF_MANY_HZ else ()
        rates = {NAV_PVT: 1, NMEA["GSA"]: self.rate_hz, NMEA["GSV"]: self.rate_hz}
        silent = {NMEA[name]: 0 for name in ("GGA", "GLL", "RMC", "VTG")}
        return (
            *(frame(CFG_MSG, bytes((m >> 8, m & 0xFF, every))) for m, every in (rates | silent).items()),
            *systems,
            frame(CFG_RATE, pack("<HHH", 1000 // self.rate_hz, 1, TIME_OF_GPS)),
            frame(CFG_NAV5, model),
        )


def _gps_alone() -> bytes:
    """CFG-GNSS: system, channels reserved and at most, 0, flags (bit 0 enabled, bit 16 the L1 signal)."""
    blocks = ((0, 8, 16, 1), (1, 1, 3, 1), (5, 0, 3, 1), (6, 8, 14, 0))
    rows = (pack("<BBBBI", system, low, high, 0, 1 << 16 | on) for system, low, high, on in blocks)
    return bytes((0, 0, 0xFF, len(blocks))) + b"".join(rows)


class Phase(Enum):
    """Where the set-up stands."""

    LISTENING = "listening"
    SWITCHING = "changing the bit rate"
    CONFIGURING = "configuring"
    RUNNING = "running"


@mypyc_attr(allow_interpreted_subclasses=True)
class Configurator:
    """Steps the set-up of one receiver. With `setup` None it is left as it comes, at any bit rate."""

    def __init__(self, uart: Uart, stream: ReceiverStream, setup: ReceiverSetup | None) -> None:
        self.phase = Phase.LISTENING
        self.baud = stream.baud
        self.refused: list[int] = []
        """Messages (class << 8 | id) that the receiver did not accept in the latest set-up."""
        self.setups = 0
        """Times the receiver was set up to the end."""
        self._uart = uart
        self._stream = stream
        self._setup = setup
        self._good_baud = self.baud
        self._tries = 0
        self._queue: list[bytes] = []
        self._attempts = 0
        self._answers: Answers | None = None
        self._since_ns: int | None = None
        """When the phase, or its bit rate, began."""
        self._sent_ns: int | None = None
        self._seen_ns = 0
        self._seen = 0
        self._bytes = 0

    def step(self, now_ns: int) -> None:
        """Look at what was heard, send what is due."""
        if self._since_ns is None:
            self._enter(Phase.LISTENING, now_ns)
        if self.phase is Phase.RUNNING:
            self._watch(now_ns)
        elif self.phase is Phase.LISTENING:
            self._listen(now_ns)
        elif self.phase is Phase.SWITCHING:
            self._switch(now_ns)
        else:
            self._configure(now_ns)

    def _enter(self, phase: Phase, now_ns: int) -> None:
        self.phase = phase
        self._since_ns = self._seen_ns = now_ns
        self._sent_ns = None
        self._attempts = 0
        self._seen = self._stream.heard()
        self._bytes = self._stream.bytes_taken()

    def _elapsed(self, now_ns: int) -> int:
        assert self._since_ns is not None
        return now_ns - self._since_ns

    # -- listening: which bit rate? ------------------------------------------------------------------

    def _listen(self, now_ns: int) -> None:
        if self._stream.heard() != self._seen:
            self._good_baud = self.baud
            self._tries = 0
            self._begin_setup(now_ns)
            return
        noise = self._stream.bytes_taken() - self._bytes > NOISE_BYTES
        if self._elapsed(now_ns) > (GARBAGE_NS if noise else SILENT_NS):
            self._set_baud(self._next_baud())
            self._enter(Phase.LISTENING, now_ns)
        elif self._setup is not None:
            self._ask(now_ns, POLL_NS)

    def _next_baud(self) -> int:
        """The other rates in turn, and between them the one that was good before."""
        self._tries += 1
        if self._tries % 2 == 0:
            return self._good_baud
        others = [rate for rate in BAUD_RATES if rate != self._good_baud]
        return others[self._tries // 2 % len(others)]

    def _set_baud(self, baud: int) -> None:
        self.baud = baud
        self._uart.set_baud(baud)
        self._stream.set_baud(baud)

    def _ask(self, now_ns: int, pause_ns: int) -> None:
        """Poll the receiver's version, at most once in `pause_ns`."""
        if (self._sent_ns is None or now_ns - self._sent_ns >= pause_ns) and self._send(frame(MON_VER)):
            self._sent_ns = now_ns

    # -- set-up --------------------------------------------------------------------------------------

    def _begin_setup(self, now_ns: int) -> None:
        if self._setup is None:
            self._enter(Phase.RUNNING, now_ns)
        elif self.baud != self._setup.baud:
            self._enter(Phase.SWITCHING, now_ns)
        else:
            self._enter(Phase.CONFIGURING, now_ns)
            self.refused = []
            self._queue = list(self._setup.messages())

    def _switch(self, now_ns: int) -> None:
        """Send CFG-PRT, follow to the new rate, ask until the receiver is understood there."""
        assert self._setup is not None
        if self.baud != self._setup.baud:
            if self._sent_ns is None:
                self._sent_ns = now_ns if self._send(self._setup.port()) else None
            elif now_ns - self._sent_ns >= SETTLE_NS:
                self._set_baud(self._setup.baud)
                self._enter(Phase.SWITCHING, now_ns)
        elif self._stream.heard() != self._seen:
            self._good_baud = self.baud
            self._begin_setup(now_ns)
        elif self._elapsed(now_ns) > ANSWER_NS:
            self._enter(Phase.LISTENING, now_ns)
        else:
            self._ask(now_ns, SETTLE_NS)

    def _configure(self, now_ns: int) -> None:
        """One message at a time, each until it is answered."""
        if self._sent_ns is not None:
            self._take_answer(now_ns)
        if self.phase is not Phase.CONFIGURING or self._sent_ns is not None:
            return
        if not self._queue:
            self.setups += 1
            self._stream.expect_last(st.NAV_PVT)
            self._enter(Phase.RUNNING, now_ns)
        elif self._send(self._queue[0]):
            self._answers = self._stream.answers()
            self._sent_ns = now_ns

    def _take_answer(self, now_ns: int) -> None:
        assert self._sent_ns is not None
        asked = int.from_bytes(self._queue[0][2:4], "big")
        before, now = self._answers, self._stream.answers()
        assert before is not None
        acknowledged = now.acks != before.acks and now.ack_of == asked
        refused = now.naks != before.naks and now.nak_of == asked
        if acknowledged or refused:
            if refused:
                self.refused.append(asked)
            del self._queue[0]
            self._attempts = 0
            self._sent_ns = None
        elif now_ns - self._sent_ns > ANSWER_NS:
            self._attempts += 1
            self._sent_ns = None
            if self._attempts >= ATTEMPTS:
                self._enter(Phase.LISTENING, now_ns)

    # -- running: is it still so? --------------------------------------------------------------------

    def _watch(self, now_ns: int) -> None:
        """Sentences count when nothing was asked for, else NAV-PVT."""
        wanted = self._stream.heard() if self._setup is None else self._stream.frames()
        if wanted != self._seen:
            self._seen = wanted
            self._seen_ns = now_ns
        elif now_ns - self._seen_ns > FORGOTTEN_NS:
            self._stream.expect_last(None)
            self._enter(Phase.LISTENING, now_ns)

    def _send(self, message: bytes) -> bool:
        """Queue a whole message, or nothing."""
        return self._uart.tx_free() >= len(message) and self._uart.write(message) == len(message)
