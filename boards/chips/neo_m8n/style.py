"""How sentences are written: NMEA version, talkers and numbering, as CFG-NMEA and CFG-GNSS set them.

Fact sheet section 1: with more than one GNSS enabled the main talker is GN, GSV keeps a talker per system,
GSA comes once per system; a GPS-only receiver uses GP everywhere. SBAS satellites are listed with GPS.
Section 2: satellite numbers and the fields that a version adds (posMode from 2.3; system id, signal id
and navStatus from 4.1; the signal id is always 0, "all signals", as in the manufacturer's example).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

VERSION_2_1 = 0x21
VERSION_2_3 = 0x23
VERSION_4_0 = 0x40
VERSION_4_1 = 0x41
VERSIONS = (VERSION_2_1, VERSION_2_3, VERSION_4_0, VERSION_4_1)

GROUP_OF_SYSTEM = {"GPS": b"GP", "SBAS": b"GP", "GLONASS": b"GL", "GALILEO": b"GA", "BEIDOU": b"GB"}
"""The talker under which a system's satellites are listed."""
GROUPS = (b"GP", b"GL", b"GA", b"GB")
SYSTEM_ID = {b"GP": 1, b"GL": 2, b"GA": 3, b"GB": 4}

_MAIN_TALKERS = (None, b"GP", b"GL", b"GN", b"GA", b"GB")


class NumberTexts(dict[tuple[str, int], bytes]):
    """Satellite (system, number) → comma and printed number, each worked out once."""

    def __init__(self, version: int, extended: bool) -> None:
        super().__init__()
        self._version = version
        self._extended = extended

    def __missing__(self, key: tuple[str, int]) -> bytes:
        """Work out and keep the text of a satellite."""
        system, number = key
        self[key] = text = b"," + number_text(system, number, self._version, self._extended)
        return text


def number_text(system: str, number: int, version: int, extended: bool) -> bytes:
    """A satellite's number as printed; empty where the version has none for it.

    Numbers come in as those of NMEA 4.0: GPS 1–32, SBAS 33–64, GLONASS 65–96, and the extended
    Galileo 301–336 and BeiDou 401–437, which 4.1 prints from 1 on.
    """
    if system not in ("GALILEO", "BEIDOU"):
        return b"%02d" % number
    if version >= VERSION_4_1:
        return b"%02d" % (number % 100)
    if not extended:
        return b""
    return b"%d" % (number % 100 + (300 if system == "GALILEO" else 400))


@dataclass(frozen=True)
class NmeaStyle:
    """Everything about the writing of sentences that does not change from epoch to epoch."""

    version: int = VERSION_4_0
    systems: frozenset[str] = frozenset(("GPS", "SBAS", "GLONASS"))
    """Enabled satellite systems."""
    hidden: frozenset[str] = frozenset()
    """Systems that are used but not listed (CFG-NMEA)."""
    most_satellites: int = 0
    """Listed per talker; 0 is no limit."""
    extended_numbers: bool = False
    fine: bool = False
    """High precision: seven decimals of minutes, three of metres."""
    show_invalid_position: bool = False
    show_frozen_course: bool = False
    main_talker_code: int = 0
    gsv_by_main_talker: bool = False
    beidou_talker: bytes = b"GB"
    manual_mode: bool = False
    """The fix is forced to 2D or 3D (CFG-NAV5)."""

    @cached_property
    def groups(self) -> tuple[bytes, ...]:
        """Talkers with at least one enabled system, in order of output."""
        enabled = {GROUP_OF_SYSTEM[system] for system in self.systems if system != "SBAS"}
        return tuple(group for group in GROUPS if group in enabled)

    @cached_property
    def listed(self) -> dict[str, bytes]:
        """Group of each system whose satellites are listed."""
        shown = self.systems - self.hidden
        return {
            system: group
            for system, group in GROUP_OF_SYSTEM.items()
            if system in shown and group in self.groups
        }

    @cached_property
    def numbers(self) -> NumberTexts:
        """Printed numbers of satellites."""
        return NumberTexts(self.version, self.extended_numbers)

    @cached_property
    def talker(self) -> bytes:
        """The main talker."""
        forced = _MAIN_TALKERS[self.main_talker_code]
        if forced is not None:
            return self.group_talker(forced)
        groups = self.groups
        return self.group_talker(groups[0]) if len(groups) == 1 else b"GN"

    def group_talker(self, group: bytes) -> bytes:
        """The talker printed for a group (BeiDou may be overridden)."""
        return self.beidou_talker if group == b"GB" else group
