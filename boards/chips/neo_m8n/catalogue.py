"""Every message the receiver can send of an epoch, in the order in which it sends them.

UBX first, by identifier, then the sentences in the order of real M8N logs (RMC VTG GGA GSA GSV GLL), the
optional ones where receivers of the family put them (GNS before GGA; GST, ZDA and PUBX at the end).
"""

from __future__ import annotations

from collections.abc import Callable

from boards.chips.neo_m8n import identity, ubx_nav, ubx_satellites
from boards.chips.neo_m8n.nmea import NmeaSet
from boards.chips.neo_m8n.pubx import pubx_00, pubx_03, pubx_04
from boards.chips.neo_m8n.solution import Solution
from boards.chips.receivers.fields import sentence

BinaryMessage = Callable[[Solution], bytes]
Sentences = Callable[[NmeaSet], list[bytes]]

BINARY: dict[int, BinaryMessage] = {
    0x0101: ubx_nav.nav_posecef,
    0x0102: ubx_nav.nav_posllh,
    0x0103: ubx_nav.nav_status,
    0x0104: ubx_nav.nav_dop,
    0x0106: ubx_nav.nav_sol,
    0x0107: ubx_nav.nav_pvt,
    0x0111: ubx_nav.nav_velecef,
    0x0112: ubx_nav.nav_velned,
    0x0120: ubx_nav.nav_timegps,
    0x0121: ubx_nav.nav_timeutc,
    0x0122: ubx_nav.nav_clock,
    0x0126: ubx_nav.nav_timels,
    0x0130: ubx_satellites.nav_svinfo,
    0x0135: ubx_satellites.nav_sat,
    0x0161: ubx_nav.nav_eoe,
    0x0A04: lambda _: identity.mon_ver(),
    0x0A09: lambda _: identity.mon_hw(),
}
"""UBX messages by class · 256 + id."""
END_OF_EPOCH = 0x0161
"""Comes behind everything else of an epoch, sentences too."""


def _one(body_of: Callable[[NmeaSet], bytes]) -> Sentences:
    return lambda nmea: [sentence(body_of(nmea))]


SENTENCES: dict[int, Sentences] = {
    0xF004: _one(NmeaSet.rmc),
    0xF005: _one(NmeaSet.vtg),
    0xF00D: _one(NmeaSet.gns),
    0xF000: _one(NmeaSet.gga),
    0xF002: lambda nmea: nmea.sky.gsa,
    0xF003: lambda nmea: nmea.sky.gsv,
    0xF001: _one(NmeaSet.gll),
    0xF007: _one(NmeaSet.gst),
    0xF008: _one(NmeaSet.zda),
    0xF100: _one(pubx_00),
    0xF103: lambda nmea: [sentence(pubx_03(nmea.solution))],
    0xF104: _one(pubx_04),
}
"""Sentences by class · 256 + id."""

SENTENCE_IDS = {
    "GGA": 0xF000,
    "GLL": 0xF001,
    "GSA": 0xF002,
    "GSV": 0xF003,
    "RMC": 0xF004,
    "VTG": 0xF005,
    "GRS": 0xF006,
    "GST": 0xF007,
    "ZDA": 0xF008,
    "GBS": 0xF009,
    "DTM": 0xF00A,
    "GNS": 0xF00D,
    "VLW": 0xF00F,
    "TXT": 0xF041,
}
"""Names that PUBX,40 and the standard polls use."""

EVENT_DRIVEN = frozenset((0xF041,))
"""TXT: comes when there is something to say, whatever its rate; CFG-INF switches it."""

_NAV_MISSING = (0x09, 0x23, 0x24, 0x25, 0x31, 0x32, 0x34, 0x39, 0x60)
_RXM_MISSING = (0x13, 0x14, 0x15, 0x41, 0x59)
_MON_MISSING = (0x02, 0x06, 0x07, 0x08, 0x0B, 0x21, 0x28, 0x2E)
_TIM_MISSING = (0x01, 0x03, 0x06)

MISSING = frozenset(
    [
        *(0x0100 | message for message in _NAV_MISSING),
        *(0x0200 | message for message in _RXM_MISSING),
        *(0x0A00 | message for message in _MON_MISSING),
        *(0x0D00 | message for message in _TIM_MISSING),
        *(0xF006, 0xF009, 0xF00A, 0xF00F, 0xF105),
    ]
)
"""Messages that a real NEO-M8N has and this model has not: their rate may be set to zero only."""
