"""What an SPI bus, the chip behind it and who watches it agree on.

Not part of the engine (`hal.engine`): a chip may name `SpiSlave` as its base class.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Protocol

from hal.emulated.virtual_time import SECOND
from hal.emulated.whole_number import whole_number

Bytes = bytes | bytearray

SpiObserver = Callable[[int, int, Bytes, Bytes], None]
"""(start_ns, end_ns, mosi, miso); the byte strings are valid during the call only."""


class SpiSlave(Protocol):
    """The bus face of a chip."""

    def transaction(self, mosi: Bytes, start_ns: int, end_ns: int) -> Bytes:
        """One chip-select low period from `start_ns` to `end_ns` with everything clocked out in it.

        Returns exactly len(mosi) bytes. Reads see the registers as of `start_ns`; writes take effect.
        Must not change or keep `mosi`.
        """
        ...


@dataclass(frozen=True)
class SpiTiming:
    """How a device is clocked. `stall_*`: pause between words inside a transaction; `high_ns`: shortest
    time that chip select stays high between two transactions."""

    frequency_hz: int
    bits_per_word: int = 8
    stall_ns: int = 0
    stall_clocks: int = 0
    setup_ns: int = 0
    hold_ns: int = 0
    high_ns: int = 0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = whole_number(getattr(self, field.name), f"SPI timing {field.name}")
            object.__setattr__(self, field.name, value)
        if self.frequency_hz <= 0:
            raise ValueError(f"SPI clock of {self.frequency_hz} Hz; it must be positive, e.g. 5_250_000")
        if self.bits_per_word not in (8, 16, 32):
            raise ValueError(f"SPI words of {self.bits_per_word} bits; 8, 16 and 32 are possible")
        for name in ("stall_ns", "stall_clocks", "setup_ns", "hold_ns", "high_ns"):
            if getattr(self, name) < 0:
                raise ValueError(f"SPI timing {name} = {getattr(self, name)}; it must not be negative")

    def duration_ns(self, length: int) -> int:
        """Chip-select low time of a transaction of `length` bytes. Raises ValueError for half words."""
        bits = 8 * length
        words, rest = divmod(bits, self.bits_per_word)
        if rest or not words:
            raise ValueError(
                f"SPI transaction of {length} bytes; with words of {self.bits_per_word} bits it must be a "
                f"positive multiple of {self.bits_per_word // 8} bytes"
            )
        clocks = bits + (words - 1) * self.stall_clocks
        pauses = self.setup_ns + (words - 1) * self.stall_ns + self.hold_ns
        return clocks * SECOND // self.frequency_hz + pauses
