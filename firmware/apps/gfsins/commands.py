"""What goes over the I²C bus between the processors. The DSP is the master, the FPGA answers at ADDRESS.

write   ALIGNED, then yaw, pitch, roll (signed tenths of a degree, high byte first)
        PRESENT alone, once a second in settings mode: the DSP is there
read    STATUS: mark, starts of the FPGA, chips missing, stuck, at odds with the others (bits each), compass,
        receiver, errors of its port, packets not sent since the one before was under way (16 bits), CRC
        (16 bits) over all of it
"""

from __future__ import annotations

from functools import lru_cache
from struct import Struct
from typing import Final

import numpy as np

from firmware.link.crc import crc16
from firmware.numerics.dialect import entry_point

ADDRESS: Final = 0x2A
ALIGNED: Final = 0x10
RESULT: Final = Struct(">B3h")
STATUS: Final = Struct(">8BH")
MARK: Final = 0x47
SETTINGS_MARK: Final = 0x53
"""The mark in settings mode."""
PRESENT: Final = 0x11
SUM: Final = Struct(">H")
STATUS_BYTES: Final = STATUS.size + SUM.size
BYTE: Final = 0xFF


@lru_cache(maxsize=4)
def pack_status(*values: int) -> bytes:
    """What a read gives: the numbers of STATUS and their sum. Mostly they are those of the time before."""
    data = STATUS.pack(*values)
    return data + SUM.pack(check_sum(data))


@lru_cache(maxsize=4)
def open_status(data: bytes) -> tuple[int, ...] | None:
    """The numbers of STATUS; None: spoilt, or of one that has not begun."""
    told, given = data[: STATUS.size], data[STATUS.size :]
    return STATUS.unpack(told) if given == SUM.pack(check_sum(told)) else None


def check_sum(data: bytes) -> int:
    """CRC-16 as in the packets."""
    found: int = entry_point(crc16)(np.frombuffer(bytearray(data), np.uint8), 0, len(data))
    return found
