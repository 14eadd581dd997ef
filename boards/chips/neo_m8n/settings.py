"""The configuration: current settings over battery-backed memory, flash and the firmware's defaults.

Every setting is kept as the payload of its own CFG message (what a poll answers), so that saving and
loading are copies. CFG-CFG works on sections (one bit each); a start loads, section by section, from the
battery-backed memory, else the flash, else the defaults. Default payloads are those of the fact sheet
(sections 1 and 4) and, where it is silent, of public dumps of M8 receivers.
"""

from __future__ import annotations

from struct import Struct

SECTION_PORTS = 0x0001
SECTION_MESSAGES = 0x0002
SECTION_TEXTS = 0x0004
SECTION_NAVIGATION = 0x0008
SECTION_RECEIVER = 0x0010
SECTIONS = (SECTION_PORTS, SECTION_MESSAGES, SECTION_TEXTS, SECTION_NAVIGATION, SECTION_RECEIVER)

DEVICE_BATTERY_BACKED = 0x01
DEVICE_FLASH = 0x02
DEVICES = (DEVICE_BATTERY_BACKED, DEVICE_FLASH)
"""In the order in which a start looks for a section."""

PRT, MSG, INF, RATE, NMEA, NAV5, TP5, GNSS = 0x00, 0x01, 0x02, 0x08, 0x17, 0x24, 0x31, 0x3E

UART1 = 1
PORTS = (0, UART1, 3, 4)
"""I²C (DDC), UART1, USB and SPI; a NEO-M8N has no UART2."""

SECTION_OF = {
    PRT: SECTION_PORTS,
    MSG: SECTION_MESSAGES,
    INF: SECTION_TEXTS,
    RATE: SECTION_NAVIGATION,
    NMEA: SECTION_NAVIGATION,
    NAV5: SECTION_NAVIGATION,
    TP5: SECTION_RECEIVER,
    GNSS: SECTION_RECEIVER,
}

Key = tuple[int, int]
"""CFG message id, and what it selects: port, protocol, message (class · 256 + id), else 0."""

PORT_LAYOUT = Struct("<BBHIIHHHH")
MODE_8N1 = 0x0000_08D0

DEFAULTS: dict[Key, bytes] = {
    (PRT, 0): PORT_LAYOUT.pack(0, 0, 0, 0x84, 0, 0x0007, 0x0003, 0, 0),
    (PRT, UART1): PORT_LAYOUT.pack(UART1, 0, 0, MODE_8N1, 9600, 0x0007, 0x0003, 0, 0),
    (PRT, 3): PORT_LAYOUT.pack(3, 0, 0, 0, 0, 0x0007, 0x0003, 0, 0),
    (PRT, 4): PORT_LAYOUT.pack(4, 0, 0, 0x3200, 0, 0x0007, 0x0003, 0, 0),
    (INF, 0): bytes((0, 0, 0, 0, 0, 0, 0, 0, 0, 0)),
    (INF, 1): bytes((1, 0, 0, 0, 7, 7, 7, 7, 7, 7)),
    (RATE, 0): bytes.fromhex("e80301000100"),
    (NMEA, 0): bytes.fromhex("0040000200000000000000010000000000000000"),
    (NAV5, 0): bytes.fromhex("ffff00030000000010270000 0500fa00fa0064005e01003c00000000 0000000000000000"),
    (TP5, 0): bytes.fromhex("0001000032000000 40420f0040420f00 00000000a0860100 00000000f7000000"),
    (GNSS, 0): bytes.fromhex(
        "00202007 0008100001000101 0101030001000101 0204080000000101 0308100000000101"
        "0400080000000103 0500030001000105 06080e0001000101"
    ),
}
DEFAULT_SENTENCES = (0xF000, 0xF001, 0xF002, 0xF003, 0xF004, 0xF005)
"""GGA GLL GSA GSV RMC VTG: rate 1 on every port."""
MESSAGE_PORTS = 6


class Settings:
    """Current settings and the two memories they can be kept in."""

    def __init__(self) -> None:
        self._current: dict[Key, bytes] = {}
        self._kept: dict[int, dict[int, dict[Key, bytes]]] = {device: {} for device in DEVICES}
        self.load(sum(SECTIONS))

    def get(self, message_id: int, selector: int = 0) -> bytes:
        """Payload of a setting."""
        return self._current[message_id, selector]

    def set(self, message_id: int, selector: int, payload: bytes) -> None:
        """Change a setting; it lasts until the next start unless it is saved."""
        self._current[message_id, selector] = payload

    def rates(self, message: int) -> bytes:
        """Rates of an output message (class · 256 + id) on the six ports."""
        return self._current.get((MSG, message), bytes(MESSAGE_PORTS))

    def save(self, sections: int, devices: int) -> None:
        """Copy sections of the current settings into memories."""
        for section in _chosen(sections):
            copy = {key: payload for key, payload in self._current.items() if SECTION_OF[key[0]] == section}
            for device in DEVICES:
                if devices & device:
                    self._kept[device][section] = copy

    def clear(self, sections: int, devices: int) -> None:
        """Forget sections in memories: the defaults take their place at the next load."""
        for section in _chosen(sections):
            for device in DEVICES:
                if devices & device:
                    self._kept[device].pop(section, None)

    def load(self, sections: int) -> None:
        """Replace sections of the current settings by what is kept."""
        for section in _chosen(sections):
            self._current = {
                key: payload for key, payload in self._current.items() if SECTION_OF[key[0]] != section
            }
            self._current.update(self._stored(section))

    def lose_battery(self) -> None:
        """The backup supply is gone, and with it the battery-backed memory."""
        self._kept[DEVICE_BATTERY_BACKED].clear()

    def _stored(self, section: int) -> dict[Key, bytes]:
        for device in DEVICES:
            if section in self._kept[device]:
                return self._kept[device][section]
        stored = {key: payload for key, payload in DEFAULTS.items() if SECTION_OF[key[0]] == section}
        if section == SECTION_MESSAGES:
            stored.update({(MSG, message): b"\1\1\1\1\1\1" for message in DEFAULT_SENTENCES})
        return stored


def _chosen(sections: int) -> list[int]:
    return [section for section in SECTIONS if sections & section]
