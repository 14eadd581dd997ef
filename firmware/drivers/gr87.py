"""GR-87 (SiRF III): the commands that set it up (fact sheet section 5). `sentence_setup` sends them,
`receiver_stream` reads what it says.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

from firmware.drivers.sentence_setup import sentence

BAUD_RATES: Final = (4800, 19_200, 9600, 38_400, 57_600)
"""In the order in which they are tried: the factory's first, then the usual one."""
MESSAGES: Final = {"GGA": 0, "GLL": 1, "GSA": 2, "GSV": 3, "RMC": 4, "VTG": 5, "ZDA": 8}
NMEA_PROTOCOL: Final = 1
SWITCH_TO_NMEA: Final = 0x81
SLOTS: Final = (0, 1, 2, 3, 4, 5, None, None, 8, None)
"""Sentences of SiRF's message 129 in its order."""


@dataclass(frozen=True)
class Gr87Setup:
    """What the receiver is asked for: bit rate, and for each sentence its period in s, 0 for none.

    Raises ValueError for what the receiver cannot do.
    """

    baud: int = 19_200
    periods_s: dict[str, int] = field(default_factory=lambda: {"GGA": 1, "GSA": 1, "GSV": 5, "RMC": 1})

    def __post_init__(self) -> None:
        if self.baud not in BAUD_RATES:
            raise ValueError(f"receiver baud is {self.baud!r}; possible: {', '.join(map(str, BAUD_RATES))}")
        for name, period in self.periods_s.items():
            if name not in MESSAGES or not 0 <= period <= 255:
                raise ValueError(
                    f"receiver sentence {name!r} every {period!r} s;"
                    f" possible: {', '.join(MESSAGES)}, 0 to 255 s"
                )

    def port(self) -> bytes:
        """The command for the port: NMEA, 8N1 at the wanted rate."""
        return sentence(f"PSRF100,{NMEA_PROTOCOL},{self.baud},8,1,0")

    def rates(self) -> bytes:
        """The commands for all sentences."""
        return b"".join(
            sentence(f"PSRF103,{number:02d},00,{self.periods_s.get(name, 0):02d},01")
            for name, number in MESSAGES.items()
        )

    @property
    def baud_rates(self) -> tuple[int, ...]:
        """In the order in which they are tried."""
        return BAUD_RATES

    def rescue(self) -> bytes:
        """SiRF message 129 for a receiver that speaks the binary protocol."""
        wanted = {MESSAGES[name]: period for name, period in self.periods_s.items()}
        pairs = [(0 if slot is None else wanted.get(slot, 0), 1) for slot in SLOTS]
        payload = bytes((SWITCH_TO_NMEA, 2)) + b"".join(map(bytes, pairs)) + self.baud.to_bytes(2, "big")
        check = sum(payload) & 0x7FFF
        return b"\xa0\xa2%b%b%b\xb0\xb3" % (
            len(payload).to_bytes(2, "big"),
            payload,
            check.to_bytes(2, "big"),
        )
