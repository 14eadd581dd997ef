"""Sentences that a host may send: PUBX,00/03/04 polls, PUBX,40, PUBX,41, and standard polls (xxGNQ,RMC).

Fact sheet section 3. None of them is acknowledged. What the receiver does not know it answers with the
warning "NMEA unknown msg", as the real one does.
"""

from __future__ import annotations

from dataclasses import dataclass

from boards.chips.neo_m8n import settings as cfg
from boards.chips.neo_m8n.catalogue import MISSING, SENTENCE_IDS, SENTENCES
from boards.chips.neo_m8n.configure import HIGHEST_BAUD, LOWEST_BAUD
from boards.chips.neo_m8n.settings import Settings

POLL_ENDINGS = ("GPQ", "GLQ", "GNQ", "GAQ", "GBQ")
RATE_FIELDS = 5
"""PUBX,40 rates: DDC, UART1, UART2, USB, SPI; a reserved one follows."""


@dataclass(frozen=True, slots=True)
class SentenceOutcome:
    """What a sentence led to: a message to print, and whether it was understood and was in order."""

    poll: int | None = None
    unknown: bool = False
    problem: str | None = None
    """What is wrong with it."""
    not_modelled: str | None = None
    """What it asks for that this model leaves out."""


UNKNOWN = SentenceOutcome(unknown=True)
TAKEN = SentenceOutcome()


def obey(fields: tuple[str, ...], settings: Settings) -> SentenceOutcome:
    """Carry out one sentence; `fields[0]` is its address."""
    address = fields[0]
    if address == "PUBX" and len(fields) > 1:
        return _proprietary(fields, settings)
    if len(address) == 5 and address[2:] in POLL_ENDINGS and len(fields) == 2:
        message = SENTENCE_IDS.get(fields[1])
        if message is None:
            return UNKNOWN
        if message not in SENTENCES:
            return SentenceOutcome(not_modelled=f"sentence {fields[1]} is not modelled")
        return SentenceOutcome(poll=message)
    return UNKNOWN


def _proprietary(fields: tuple[str, ...], settings: Settings) -> SentenceOutcome:
    kind = fields[1]
    if kind in ("00", "03", "04") and len(fields) == 2:
        return SentenceOutcome(poll=0xF100 | int(kind))
    if kind == "40":
        return _set_rate(fields, settings)
    if kind == "41":
        return _set_port(fields, settings)
    return UNKNOWN


def _set_rate(fields: tuple[str, ...], settings: Settings) -> SentenceOutcome:
    """PUBX,40: rate of a sentence on each port."""
    if len(fields) < 3 + RATE_FIELDS:
        return SentenceOutcome(problem="PUBX,40 with too few fields")
    message = SENTENCE_IDS.get(fields[2])
    if message is None:
        return SentenceOutcome(problem=f"PUBX,40: there is no sentence {fields[2]!r}")
    rates = [_number(text, 10, 255) for text in fields[3 : 3 + RATE_FIELDS]]
    if None in rates:
        return SentenceOutcome(problem="PUBX,40 with a rate that is not 0 to 255")
    if message in MISSING and rates[cfg.UART1]:
        return SentenceOutcome(not_modelled=f"sentence {fields[2]} is not modelled")
    settings.set(cfg.MSG, message, bytes(rate or 0 for rate in (*rates, 0)))
    return TAKEN


def _set_port(fields: tuple[str, ...], settings: Settings) -> SentenceOutcome:
    """PUBX,41: protocols and baud rate of a port."""
    if len(fields) < 7:
        return SentenceOutcome(problem="PUBX,41 with too few fields")
    port, baud, autobaud = (_number(fields[index], 10, 1 << 31) for index in (2, 5, 6))
    in_mask, out_mask = (_number(fields[index], 16, 0xFFFF) for index in (3, 4))
    if port is None or in_mask is None or out_mask is None or baud is None or autobaud is None:
        return SentenceOutcome(problem="PUBX,41 with a field that is no number")
    if port not in cfg.PORTS or (port == cfg.UART1 and not LOWEST_BAUD <= baud <= HIGHEST_BAUD):
        return SentenceOutcome(problem=f"PUBX,41: port {port} at {baud} baud is not possible")
    block = list(cfg.PORT_LAYOUT.unpack(settings.get(cfg.PRT, port)))
    block[4:7] = baud, in_mask, out_mask
    settings.set(cfg.PRT, port, cfg.PORT_LAYOUT.pack(*block))
    if autobaud:
        return SentenceOutcome(not_modelled="PUBX,41: automatic baud detection is not modelled")
    return TAKEN


def _number(text: str, base: int, highest: int) -> int | None:
    """A plain unsigned number, or None."""
    if not text.isalnum() or not text.isascii():
        return None
    try:
        value = int(text, base)
    except ValueError:
        return None
    return value if value <= highest else None
