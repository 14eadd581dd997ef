"""The two-antenna receiver: the commands that set it up, as Hemisphere receivers take them. `sentence_setup`
sends them, `receiver_stream` reads what it says: position, velocity, heading, pitch, roll.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

BAUD_RATES: Final = (19_200, 38_400, 115_200, 9600, 57_600, 4800)
"""In the order in which they are tried: the factory's first."""
NAMES: Final = {
    "GGA": "GPGGA",
    "RMC": "GPRMC",
    "VTG": "GPVTG",
    "ZDA": "GPZDA",
    "GST": "GPGST",
    "HDT": "GPHDT",
    "THS": "GPTHS",
    "PASHR": "PASHR",
    "PSAT,HPR": "PSAT,HPR",
    "PTNL,AVR": "PTNL,AVR",
}
RATES_HZ: Final = (0, 1, 2, 5, 10, 20)


@dataclass(frozen=True)
class DualAntennaSetup:
    """What the receiver is asked for: bit rate, and for each sentence its rate in Hz, 0 for none.

    Raises ValueError for what the receiver cannot do.
    """

    baud: int = 38_400
    rates_hz: dict[str, int] = field(default_factory=lambda: {"GGA": 1, "RMC": 1, "GST": 1, "PASHR": 1})

    def __post_init__(self) -> None:
        if self.baud not in BAUD_RATES:
            raise ValueError(f"receiver baud is {self.baud!r}; possible: {', '.join(map(str, BAUD_RATES))}")
        for name, rate in self.rates_hz.items():
            if name not in NAMES or rate not in RATES_HZ:
                raise ValueError(
                    f"receiver sentence {name!r} at {rate!r} Hz; possible: {' '.join(NAMES)},"
                    f" at {', '.join(map(str, RATES_HZ))} Hz"
                )

    @property
    def baud_rates(self) -> tuple[int, ...]:
        """In the order in which they are tried."""
        return BAUD_RATES

    def port(self) -> bytes:
        """The command for the bit rate."""
        return b"$JBAUD,%d\r\n" % self.baud

    def rates(self) -> bytes:
        """No sentences, then those that are wanted."""
        wanted = ((NAMES[name].encode(), rate) for name, rate in self.rates_hz.items() if rate)
        return b"$JOFF\r\n" + b"".join(b"$JASC,%b,%d\r\n" % one for one in wanted)

    def rescue(self) -> bytes:
        """It speaks sentences only."""
        return b""
