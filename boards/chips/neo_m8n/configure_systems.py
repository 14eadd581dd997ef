"""CFG-NMEA, CFG-NAV5 and CFG-GNSS: what their payloads may hold and what follows from them.

Layouts are those of public M8 definitions: CFG-NMEA has 20 bytes (older forms of 4 and 12 bytes set the
first ones only), CFG-NAV5 36 bytes of which the mask chooses, CFG-GNSS 4 bytes and 8 for each system.
"""

from __future__ import annotations

from boards.chips.neo_m8n import settings as cfg
from boards.chips.neo_m8n.engine import MODE_2D_ONLY, MODE_3D_ONLY
from boards.chips.neo_m8n.settings import Settings
from boards.chips.neo_m8n.style import VERSIONS, NmeaStyle

SYSTEM_OF_GNSS_ID = {0: "GPS", 1: "SBAS", 2: "GALILEO", 3: "BEIDOU", 6: "GLONASS"}
SYSTEM_OF_FILTER_BIT = {0: "GPS", 1: "SBAS", 2: "GALILEO", 5: "GLONASS", 6: "BEIDOU"}

NMEA_SIZE = 20
NMEA_OLD_SIZES = (4, 12)
FILTER_POSITION, FILTER_TIME, FILTER_DATE, FILTER_GPS_ONLY, FILTER_COURSE = 0x01, 0x04, 0x08, 0x10, 0x20
FLAG_COMPATIBLE, FLAG_LIMIT_82, FLAG_HIGH_PRECISION = 0x01, 0x04, 0x08

NAV5_SIZE = 36
NAV5_FIELDS: dict[int, tuple[slice, ...]] = {
    0: (slice(2, 3),),  # dynamic model
    1: (slice(12, 13),),  # lowest elevation
    2: (slice(3, 12),),  # fix mode, fixed altitude and its variance
    3: (slice(13, 14),),  # dead reckoning limit
    4: (slice(14, 16), slice(18, 20)),  # position masks
    5: (slice(16, 18), slice(20, 22)),  # time masks
    6: (slice(22, 23), slice(28, 30)),  # static hold
    7: (slice(23, 24),),  # differential time-out
    8: (slice(24, 26),),  # C/N0 threshold
    10: (slice(30, 31),),  # UTC standard
}
"""Fields of CFG-NAV5 by the bit of its mask that applies them."""
DYNAMIC_MODELS = (0, 2, 3, 4, 5, 6, 7, 8)


def nmea_update(current: bytes, payload: bytes) -> bytes | None:
    """The 20 bytes after a write; None when its length is wrong."""
    if len(payload) == NMEA_SIZE:
        return payload
    if len(payload) in NMEA_OLD_SIZES:
        return payload + current[len(payload) :]
    return None


def nmea_problem(payload: bytes) -> str | None:
    """Why these 20 bytes are refused, if so."""
    if payload[1] not in VERSIONS:
        return f"NMEA version 0x{payload[1]:02X}: this receiver has 0x21, 0x23, 0x40 and 0x41"
    if payload[2] not in (0, 8, 12, 16):
        return f"{payload[2]} satellites per talker: 0 (no limit), 8, 12 or 16"
    if payload[3] & FLAG_COMPATIBLE:
        return "compatibility mode is not modelled"
    if payload[0] & (FILTER_TIME | FILTER_DATE):
        return "output of invalid times and dates is not modelled"
    if payload[8] > 1 or payload[9] > 5 or payload[10] > 1:
        return "unknown numbering or talker"
    if any(payload[12:14]) and not payload[12:14].isalnum():
        return "the BeiDou talker is not two letters"
    return None


def nav5_update(current: bytes, payload: bytes) -> bytes | None:
    """The 36 bytes after a write of the fields that its mask chooses; None when it is refused."""
    if len(payload) != NAV5_SIZE:
        return None
    mask = payload[0] | payload[1] << 8
    updated = bytearray(current)
    for bit, fields in NAV5_FIELDS.items():
        if mask >> bit & 1:
            for field in fields:
                updated[field] = payload[field]
    if updated[2] not in DYNAMIC_MODELS or not 1 <= updated[3] <= 3:
        return None
    return bytes(updated)


def gnss_update(current: bytes, payload: bytes) -> bytes | None:
    """All blocks after a write of some; None when it is malformed or names an unknown system."""
    if len(payload) < 4 or len(payload) != 4 + 8 * payload[3]:
        return None
    blocks = {current[start]: current[start : start + 8] for start in range(4, len(current), 8)}
    for start in range(4, len(payload), 8):
        if payload[start] not in blocks:
            return None
        blocks[payload[start]] = payload[start : start + 8]
    return current[:4] + b"".join(blocks.values())


def gnss_problem(payload: bytes) -> str | None:
    """Why this choice of systems is refused, if so."""
    systems = enabled_systems(payload)
    if not systems - {"SBAS"}:
        return "no satellite system is left"
    if "BEIDOU" in systems and "GLONASS" in systems and systems & {"GPS", "GALILEO"}:
        return "GPS/Galileo, GLONASS and BeiDou at once: the receiver has two frequency bands"
    return None


def enabled_systems(gnss: bytes) -> frozenset[str]:
    """Systems that a CFG-GNSS payload enables (IMES and QZSS are not in the emulated sky)."""
    return frozenset(
        SYSTEM_OF_GNSS_ID[gnss[start]]
        for start in range(4, len(gnss), 8)
        if gnss[start] in SYSTEM_OF_GNSS_ID and gnss[start + 4] & 1
    )


def fix_mode(settings: Settings) -> int:
    """CFG-NAV5 fix mode: 1 2D only, 2 3D only, 3 automatic."""
    return settings.get(cfg.NAV5)[3]


def style_of(settings: Settings) -> NmeaStyle:
    """How sentences are to be written."""
    nmea = settings.get(cfg.NMEA)
    filters, flags = nmea[0], nmea[3]
    systems = enabled_systems(settings.get(cfg.GNSS))
    hidden = {name for bit, name in SYSTEM_OF_FILTER_BIT.items() if nmea[4] >> bit & 1}
    if filters & FILTER_GPS_ONLY:
        hidden |= systems - {"GPS"}
    beidou = bytes(nmea[12:14])
    return NmeaStyle(
        version=nmea[1],
        systems=systems,
        hidden=frozenset(hidden),
        most_satellites=nmea[2],
        extended_numbers=nmea[8] == 1,
        fine=bool(flags & FLAG_HIGH_PRECISION) and not flags & FLAG_LIMIT_82,
        show_invalid_position=bool(filters & FILTER_POSITION),
        show_frozen_course=bool(filters & FILTER_COURSE),
        main_talker_code=nmea[9],
        gsv_by_main_talker=nmea[10] == 1,
        beidou_talker=beidou if any(beidou) else b"GB",
        manual_mode=fix_mode(settings) in (MODE_2D_ONLY, MODE_3D_ONLY),
    )
