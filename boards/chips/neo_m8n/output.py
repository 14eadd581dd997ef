"""What leaves the port: which messages, how often, under which protocol mask, in which style.

The settings act here only when `apply` is called, so that an acknowledgement still leaves under the
settings that were in force when its message came.
"""

from __future__ import annotations

from boards.chips.neo_m8n import settings as cfg
from boards.chips.neo_m8n.catalogue import BINARY, END_OF_EPOCH, SENTENCES, BinaryMessage, Sentences
from boards.chips.neo_m8n.configure_systems import style_of
from boards.chips.neo_m8n.identity import START_UP_TEXTS
from boards.chips.neo_m8n.nmea import TXT_ERROR, TXT_NOTICE, NmeaSet, txt
from boards.chips.neo_m8n.satellites import PrintedSkies
from boards.chips.neo_m8n.settings import Settings
from boards.chips.neo_m8n.solution import Solution
from boards.chips.neo_m8n.style import NmeaStyle
from boards.chips.neo_m8n.ubx import CLASS_INF, frame
from boards.chips.receivers.fields import sentence
from boards.chips.receivers.transmitter import Transmitter
from boards.chips.transmit_line import TransmitLine
from hal.emulated.virtual_time import VirtualTime

PROTOCOL_UBX, PROTOCOL_NMEA = 1, 2


class Output:
    """The sending side of UART1."""

    def __init__(self, time: VirtualTime, line: TransmitLine, settings: Settings, capacity: int) -> None:
        self.transmitter = Transmitter(time, line, capacity, self._overrun_text)
        self.in_mask = 0
        self.style = NmeaStyle()
        self._settings = settings
        self._skies = PrintedSkies()
        self._out_mask = 0
        self._epochs = 0
        self._binary: list[tuple[int, BinaryMessage]] = []
        self._sentences: list[tuple[int, Sentences]] = []
        self._end_rate = 0

    def start(self) -> None:
        """The port comes up: settings, baud rate, start-up texts."""
        self._epochs = 0
        baud = self._adopt()
        self.transmitter.start(baud)
        self.transmitter.send(
            [message for text in START_UP_TEXTS for message in self._text(TXT_NOTICE, text)]
        )

    def apply(self) -> None:
        """Bring changed settings into force; a new baud rate after what is queued."""
        self.transmitter.change_baud(self._adopt())

    def epoch(self, solution: Solution) -> None:
        """Send what is due with this epoch."""
        self._epochs += 1
        count = self._epochs
        messages: list[bytes] = []
        for rate, build in self._binary:
            if count % rate == 0:
                messages.append(build(solution))
        if self._sentences:
            printed = NmeaSet(solution, self.style, self._skies.of)
            for rate, sentences_of in self._sentences:
                if count % rate == 0:
                    messages += sentences_of(printed)
        if self._end_rate and count % self._end_rate == 0:
            messages.append(BINARY[END_OF_EPOCH](solution))
        if messages:
            self.transmitter.send(messages)

    def poll(self, message: int, solution: Solution) -> None:
        """Send one message (class · 256 + id) of the newest solution at once."""
        if message in SENTENCES:
            printed = NmeaSet(solution, self.style)
            self._send(PROTOCOL_NMEA, SENTENCES[message](printed))
        else:
            self._send(PROTOCOL_UBX, [BINARY[message](solution)])

    def frames(self, frames: tuple[bytes, ...]) -> None:
        """Send UBX frames."""
        self._send(PROTOCOL_UBX, list(frames))

    def text(self, kind: int, text: bytes) -> None:
        """Send a text where CFG-INF wants texts of this kind."""
        messages = self._text(kind, text)
        if messages:
            self.transmitter.send(messages)

    def _send(self, protocol: int, messages: list[bytes]) -> None:
        if self._out_mask & protocol:
            self.transmitter.send(messages)

    def _text(self, kind: int, text: bytes) -> list[bytes]:
        messages = []
        if self._out_mask & PROTOCOL_UBX and self._wanted(0, kind):
            messages.append(frame(CLASS_INF, kind, text))
        if self._out_mask & PROTOCOL_NMEA and self._wanted(1, kind):
            messages.append(sentence(txt(self.style.talker, kind, text)))
        return messages

    def _wanted(self, protocol: int, kind: int) -> bool:
        return bool(self._settings.get(cfg.INF, protocol)[4 + cfg.UART1] >> kind & 1)

    def _overrun_text(self) -> bytes:
        return b"".join(self._text(TXT_ERROR, b"txbuf alloc"))

    def _adopt(self) -> int:
        """Take over the settings; the baud rate is returned, it needs its own moment."""
        settings = self._settings
        _, _, _, _, baud, in_mask, out_mask, _, _ = cfg.PORT_LAYOUT.unpack(settings.get(cfg.PRT, cfg.UART1))
        self.in_mask, self._out_mask = in_mask, out_mask
        style = style_of(settings)
        if style != self.style:
            self.style = style
        self._binary = [
            (rate, build)
            for message, build in BINARY.items()
            if out_mask & PROTOCOL_UBX and (rate := settings.rates(message)[cfg.UART1])
            if message != END_OF_EPOCH
        ]
        self._end_rate = settings.rates(END_OF_EPOCH)[cfg.UART1] if out_mask & PROTOCOL_UBX else 0
        self._sentences = [
            (rate, sentences_of)
            for message, sentences_of in SENTENCES.items()
            if out_mask & PROTOCOL_NMEA and (rate := settings.rates(message)[cfg.UART1])
        ]
        return int(baud)
